#!/bin/bash
# Scenes that nobody tuned Spall for, beside LAMMPS in turns, from one start file each; writes README.md's table.
# SPDX-License-Identifier: BSD-3-Clause
# usage: run_untuned.sh [BUILD [REPETITIONS [FOLDER]]]; FOLDER keeps the start files. LAMMPS is Debian's, and one built
# from Debian's source for this processor, in LAMMPS_FOLDER if given (peers/build_lammps.sh).
set -eu
. "$(dirname "$(realpath "$0")")/beside_peers.sh"
spall=$(realpath "${1:-build/release}")/spall
inputs=$here/untuned
repetitions=${2:-3}
work_in "${3:-}"
native=$("$here/peers/build_lammps.sh" "${LAMMPS_FOLDER:-lammps}")
cp "$(dirname "$native")"/../bench/{data.chute,in.chute,in.lj} .
# The scenes as both programs start from: LAMMPS writes its own melt.
if [ ! -f melt.data ]; then
  sed -e 's/^run.*/run 0/' in.lj >write_melt.in
  echo "write_data melt.data nocoeff" >>write_melt.in
  "$lmp" -in write_melt.in >/dev/null
fi
[ -f bed.data ] || /usr/bin/python3 "$inputs/make_bed.py" 50000 bed.data
cp "$inputs"/*.toml .
cp data.chute chute.data
edge=$(awk '/xlo xhi/ {print $2}' bed.data)

# scene, bodies, steps, step, ranks -> "million steps a second, share of a processor, bytes a body"
run_spall_case() {
  rm -rf "$1.out" time.*
  start_from "$1.data" "$1"
  [ "$1" != bed ] || start+=(--set "periodic.size=[$edge, $edge, $edge]")
  mpirun --oversubscribe -n "$5" /usr/bin/env bash -c \
    '/usr/bin/time -o "time.$OMPI_COMM_WORLD_RANK" -f "%M kB %U user %e s" "$@"' bash \
    "$spall" run "$1.toml" --out "$1.out" --overwrite "${start[@]}" \
    --set "phases.0.duration=$(awk -v n="$3" -v h="$4" 'BEGIN {printf "%.17g", n * h}')" >out
  # What reading and writing take is not the steps'.
  awk -v n="$2" -v steps="$3" '/ kB / {share = $3 / $5; sum += $1} /^total_s/ {t += $3} /^(output|analysis)_s/ {t -= $3}
    END {printf "%.4g %.3g %.4g\n", 1e-6 * n * steps / t, share, 1024 * sum / n}' time.* "$1.out/results.toml"
}

# Long enough for what Spall does before its first step, which no loop of LAMMPS holds, to count for little.
chute_steps=3000 bed_steps=2000
sed -e "s/^run.*/run $chute_steps/" in.chute >chute.in
begin_records
for ranks in 1 2; do
  for repetition in $(seq "$repetitions"); do
    record chute $ranks "$repetition" spall "$(run_spall_case chute 32000 $chute_steps 1e-4 $ranks)"
    record melt $ranks "$repetition" spall "$(run_spall_case melt 32000 500 0.005 $ranks)"
    record bed $ranks "$repetition" spall "$(run_spall_case bed 50000 $bed_steps 1e-4 $ranks)"
    for program in "lammps $lmp" "native $native"; do
      read -r name peer <<<"$program"
      record chute $ranks "$repetition" "$name" "$(run_peer 32000 $chute_steps $ranks "$peer" -in chute.in)"
      for style in lj/cut lj/cut/opt; do
        sed -e 's/^run.*/run 500/' -e "s#lj/cut#$style#" in.lj >melt.in
        record melt $ranks "$repetition" "$name ${style#lj/}" "$(run_peer 32000 500 $ranks "$peer" -in melt.in || true)"
      done
      for style in bin multi; do
        record bed $ranks "$repetition" "$name $style" "$(run_peer 50000 $bed_steps $ranks "$peer" -in "$inputs/bed.in" \
          -var data bed.data -var style $style -var skin 0.05 -var steps $bed_steps || true)"
      done
    done
  done
done
write_records untuned
