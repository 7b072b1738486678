#!/bin/bash
# A dense packing in penalty contact side by side with LAMMPS and LIGGGHTS, from one file, in turns; writes README.md's table.
# SPDX-License-Identifier: BSD-3-Clause
# usage: run_granular.sh [BUILD [REPETITIONS [STEPS [FOLDER [PACKINGS]]]]]; FOLDER keeps the packings, which
# take minutes to make; PACKINGS: p97k p780k
set -eu
. "$(dirname "$(realpath "$0")")/beside_peers.sh"
bench=$(realpath "${1:-build/release}")/bench/bench_granular
inputs=$here/granular
repetitions=${2:-3} steps=${3:-50}
[ -n "$liggghts" ] || echo "LIGGGHTS is not installed (apt-get install liggghts): without it"
work_in "${4:-}"
if [ ! -f p780k.data ]; then
  "$lmp" -in "$inputs/make_packing.in" -var n 12190 -var phi 0.645 -var out packing.xyz >/dev/null
  /usr/bin/python3 "$inputs/replicate.py" packing.xyz start.data 1
  "$lmp" -in "$inputs/relax_packing.in" -var data start.data -var steps 3000 -var out relaxed.xyz >/dev/null
  /usr/bin/python3 "$inputs/replicate.py" relaxed.xyz p12k.data 1 0.001
  /usr/bin/python3 "$inputs/replicate.py" relaxed.xyz p97k.data 2 0.001
  /usr/bin/python3 "$inputs/replicate.py" relaxed.xyz p780k.data 4 0.001
fi

echo "largest difference of forces and torques from LAMMPS, of the largest of them"
for model in mindlin jkr; do
  "$lmp" -in "$inputs/lammps.in" -var data p12k.data -var model $model -var steps 1 -var forces yes >/dev/null
  echo "$model: $("$bench" p12k.data $model forces forces.dump)"
done

begin_records
for data in ${5:-p97k p780k}; do
  n=$(awk '/atoms/ {print $1; exit}' "$data.data")
  for ranks in 1 2; do
    for repetition in $(seq "$repetitions"); do
      for model in hertz mindlin jkr; do
        arguments=(-var data "$data.data" -var steps "$steps")
        scene="$data $model"
        record "$scene" $ranks "$repetition" spall "$(run_spall $ranks "$bench" "$data.data" $model "$steps" 1)"
        record "$scene" $ranks "$repetition" lammps \
          "$(run_peer "$n" "$steps" $ranks "$lmp" -in "$inputs/lammps.in" -var model $model "${arguments[@]}" || true)"
        [ -z "$liggghts" ] || [ $model != hertz ] || record "$scene" $ranks "$repetition" liggghts \
          "$(run_peer "$n" "$steps" $ranks "$liggghts" -in "$inputs/liggghts.in" "${arguments[@]}" || true)"
      done
    done
  done
done
write_records granular
