# What the benches beside LAMMPS share: a folder, start files, programs in turns, one line of CSV a run.
# SPDX-License-Identifier: BSD-3-Clause
here=$(dirname "$(realpath "${BASH_SOURCE[0]}")")
lmp=$(command -v lmp || command -v lammps || true)
liggghts=$(command -v liggghts || true)
[ -n "$lmp" ] || { echo "skipped: LAMMPS is not installed (apt-get install lammps)"; exit 0; }
[ -x /usr/bin/time ] || { echo "skipped: /usr/bin/time is not installed (apt-get install time)"; exit 0; }
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMP_NUM_THREADS=1

# The folder that is given, or one that goes with the script.
work_in() {
  local folder=${1:-$(mktemp -d)}
  mkdir -p "$folder"
  cd "$folder"
  # shellcheck disable=SC2064
  [ -n "$1" ] || trap "rm -rf '$folder'" EXIT
}
# data file of LAMMPS, name of its groups -> files of bodies, and options of `spall run` in the array `start`
start_from() {
  local settings setting
  mapfile -t settings < <(/usr/bin/python3 "$here/untuned/data_to_restart.py" "$1" "$2")
  start=()
  for setting in "${settings[@]}"; do start+=(--set "$setting"); done
}
# ranks, command … -> "million steps a second, share of a processor, bytes a body"
run_spall() {
  mpirun --oversubscribe -n "$1" "${@:2}" >out
  awk '/^bodies/ {for (k = 1; k < NF; k++) f[$k] = $(k + 1)
    print f["Msteps/s"], (f["cpu"] > 0 ? f["Msteps/s"] / f["cpu"] : 1), f["bytes"]}' out
}
# bodies, steps, ranks, command of LAMMPS or LIGGGHTS … -> the same
run_peer() {
  rm -f time.*
  mpirun --oversubscribe -n "$3" /usr/bin/env bash -c \
    '/usr/bin/time -o "time.$OMPI_COMM_WORLD_RANK" -f "%M kB %U user %e s" "$@"' bash "${@:4}" >out
  # LIGGGHTS does not print its share of a processor: that of the whole run.
  awk -v n="$1" -v steps="$2" '/ kB / {whole = $3 / $5; sum += $1} /^Loop time/ {t = $4} /CPU use/ {share = $1 / 100}
    END {printf "%.4g %.3g %.4g\n", 1e-6 * n * steps / t, (share ? share : whole), 1024 * sum / n}' time.* out
}
# scene, ranks, repetition, program, result of one of these
record() {
  local speed share bytes
  [ "$(wc -w <<<"$5")" = 3 ] || return 0  # not every LAMMPS has every style
  read -r speed share bytes <<<"$5"
  echo "$1,$2,$3,$4,$speed,$share,$(awk -v a="$speed" -v b="$share" 'BEGIN {printf "%.4g", a / b}'),$bytes" | tee -a all.csv
}
begin_records() {
  echo "scene,ranks,repetition,program,million_steps_s,share_of_processor,million_steps_processor_s,bytes_a_body" | tee all.csv
}
# name: of the section in README.md
write_records() {
  cp all.csv "$here/results/$1.csv"
  /usr/bin/python3 "$here/beside_peers.py" "$1"
}
