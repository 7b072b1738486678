#!/bin/bash
# Scenes that nobody tuned Spall for, beside LAMMPS in turns, from one start file each; writes README.md's table.
# SPDX-License-Identifier: BSD-3-Clause
# usage: run_untuned.sh [BUILD [REPETITIONS [FOLDER]]]; FOLDER keeps the start files. LAMMPS's bench folder is that of
# LAMMPS_BENCH, else it comes from Debian's source package (80 MB).
set -eu
. "$(dirname "$(realpath "$0")")/beside_peers.sh"
spall=$(realpath "${1:-build/release}")/spall
inputs=$here/untuned
repetitions=${2:-3}
work=${3:-$(mktemp -d)}
mkdir -p "$work"
[ $# -ge 3 ] || trap 'rm -rf "$work"' EXIT
cd "$work"
if [ ! -f data.chute ]; then
  if [ -z "${LAMMPS_BENCH:-}" ]; then
    echo "deb-src [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] http://deb.debian.org/debian bookworm main" >sources.list
    mkdir -p lists/partial source
    options=(-o "Dir::Etc::sourcelist=$PWD/sources.list" -o Dir::Etc::sourceparts=- -o "Dir::State::lists=$PWD/lists")
    apt-get "${options[@]}" update >/dev/null
    apt-get "${options[@]}" --download-only source lammps >/dev/null
    tar xJf lammps_*.orig.tar.xz -C source --wildcards '*/bench/in.*' '*/bench/data.chute'
    LAMMPS_BENCH=$(dirname source/*/bench/data.chute)
  fi
  cp "$LAMMPS_BENCH"/{data.chute,in.chute,in.lj} .
fi
# The scenes as both programs start from: LAMMPS writes its own melt.
if [ ! -f melt.data ]; then
  sed -e 's/^run.*/run 0/' in.lj >write_melt.in
  echo "write_data melt.data nocoeff" >>write_melt.in
  "$lmp" -in write_melt.in >/dev/null
fi
[ -f bed.data ] || /usr/bin/python3 "$inputs/make_bed.py" 50000 bed.data
cp "$inputs"/*.toml .
declare -A centres
for scene in chute melt bed; do
  data=$scene.data
  [ $scene != chute ] || data=data.chute
  centres[$scene]=$(/usr/bin/python3 "$inputs/data_to_restart.py" "$data" $scene)
done
edge=$(awk '/xlo xhi/ {print $2}' bed.data)

# scene, bodies, steps, step, ranks -> "million steps a second, share of a processor, bytes a body"
run_spall_case() {
  rm -rf "$1.out" time.*
  mapfile -t options <<<"${centres[$1]}"
  local more=()
  [ "$1" != bed ] || more=(--set "periodic.size=[$edge, $edge, $edge]")
  local words=()
  for option in "${options[@]}"; do words+=(--set "${option#--set }"); done
  mpirun --oversubscribe -n "$5" /usr/bin/env bash -c \
    '/usr/bin/time -o "time.$OMPI_COMM_WORLD_RANK" -f "%M kB %U user %e s" "$@"' bash \
    "$spall" run "$1.toml" --out "$1.out" --overwrite "${words[@]}" "${more[@]}" \
    --set "phases.0.duration=$(awk -v n="$3" -v h="$4" 'BEGIN {printf "%.17g", n * h}')" >out
  # What reading and writing take is not the steps'.
  awk -v n="$2" -v steps="$3" '/ kB / {share = $3 / $5; sum += $1} /^total_s/ {t += $3} /^(output|analysis)_s/ {t -= $3}
    END {printf "%.4g %.3g %.4g\n", 1e-6 * n * steps / t, share, 1024 * sum / n}' time.* "$1.out/results.toml"
}

begin_records
for ranks in 1 2; do
  for repetition in $(seq "$repetitions"); do
    record chute $ranks "$repetition" spall "$(run_spall_case chute 32000 1000 1e-4 $ranks)"
    sed -e 's/^run.*/run 1000/' in.chute >chute.in
    record chute $ranks "$repetition" lammps "$(run_peer 32000 1000 $ranks "$lmp" -in chute.in)"
    record melt $ranks "$repetition" spall "$(run_spall_case melt 32000 500 0.005 $ranks)"
    for style in lj/cut lj/cut/opt; do
      sed -e 's/^run.*/run 500/' -e "s#lj/cut#$style#" in.lj >melt.in
      record melt $ranks "$repetition" "${style/lj/lammps}" "$(run_peer 32000 500 $ranks "$lmp" -in melt.in || true)"
    done
    record bed $ranks "$repetition" spall "$(run_spall_case bed 50000 500 1e-4 $ranks)"
    for style in bin multi; do
      record bed $ranks "$repetition" "lammps $style" "$(run_peer 50000 500 $ranks "$lmp" -in "$inputs/bed.in" \
        -var data bed.data -var style $style -var skin 0.05 -var steps 500 || true)"
    done
  done
done
write_records untuned
