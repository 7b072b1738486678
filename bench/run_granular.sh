#!/bin/bash
# A dense packing in penalty contact side by side with LAMMPS and LIGGGHTS, from one file, in turns.
# SPDX-License-Identifier: BSD-3-Clause
# usage: run_granular.sh [BUILD [REPETITIONS [STEPS [FOLDER [PACKINGS]]]]]; FOLDER keeps the packings, which
# take minutes to make; PACKINGS: p97k p780k
set -eu
bench=$(realpath "${1:-build/release}")/bench/bench_granular
inputs=$(dirname "$(realpath "$0")")/granular
repetitions=${2:-3} steps=${3:-50}
lmp=$(command -v lmp || command -v lammps || true)
liggghts=$(command -v liggghts || true)
[ -n "$lmp" ] || { echo "skipped: LAMMPS is not installed (apt-get install lammps)"; exit 0; }
[ -n "$liggghts" ] || echo "LIGGGHTS is not installed (apt-get install liggghts): without it"
[ -x /usr/bin/time ] || { echo "skipped: /usr/bin/time is not installed (apt-get install time)"; exit 0; }
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMP_NUM_THREADS=1
work=${4:-$(mktemp -d)}
mkdir -p "$work"
[ $# -ge 4 ] || trap 'rm -rf "$work"' EXIT
cd "$work"
if [ ! -f p780k.data ]; then
  "$lmp" -in "$inputs/make_packing.in" -var n 12190 -var phi 0.645 -var out packing.xyz >/dev/null
  /usr/bin/python3 "$inputs/dump2data.py" packing.xyz start.data 1 1 1
  "$lmp" -in "$inputs/relax_packing.in" -var data start.data -var steps 3000 -var out relaxed.xyz >/dev/null
  /usr/bin/python3 "$inputs/dump2data.py" relaxed.xyz p12k.data 1 1 1 0.001
  /usr/bin/python3 "$inputs/dump2data.py" relaxed.xyz p97k.data 2 2 2 0.001
  /usr/bin/python3 "$inputs/dump2data.py" relaxed.xyz p780k.data 4 4 4 0.001
fi

echo "largest difference of forces and torques from LAMMPS, of the largest of them"
for model in mindlin jkr; do
  "$lmp" -in "$inputs/lammps.in" -var data p12k.data -var model $model -var steps 1 -var forces yes >/dev/null
  echo "$model: $("$bench" p12k.data $model forces forces.dump)"
done

# program, model, data, ranks -> "million steps a second, share of a processor, bytes a body"
run() {
  local program=$1 model=$2 data=$3 ranks=$4 n
  n=$(awk '/atoms/ {print $1; exit}' "$data")
  if [ "$program" = spall ]; then
    mpirun --oversubscribe -n "$ranks" "$bench" "$data" "$model" "$steps" 1 >out
    awk '/^bodies/ {for (k = 1; k < NF; k++) f[$k] = $(k + 1)
      print f["Msteps/s"], f["Msteps/s"] / f["cpu"], f["bytes"]}' out
    return
  fi
  local command=("$lmp" -in "$inputs/lammps.in" -var model "$model")
  [ "$program" = lammps ] || command=("$liggghts" -in "$inputs/liggghts.in")
  mpirun --oversubscribe -n "$ranks" /usr/bin/env bash -c '/usr/bin/time -f "%M kB %U user %e s" "$@"' bash \
    "${command[@]}" -var data "$data" -var steps "$steps" >out 2>err
  # LIGGGHTS does not print its share of a processor: that of the whole run.
  awk -v n="$n" -v steps="$steps" '/ kB / {whole = $3 / $5} /^Loop time/ {t = $4} /CPU use/ {share = $1 / 100}
    END {printf "%.4g %.3g ", 1e-6 * n * steps / t, share ? share : whole}' err out
  awk -v n="$n" '/ kB / {sum += $1} END {printf "%.4g\n", 1024 * sum / n}' err
}

echo "data,model,ranks,repetition,program,million_steps_s,share_of_processor,million_steps_processor_s,bytes_a_body"
rm -f all.csv
for data in ${5:-p97k p780k}; do
  for ranks in 1 2; do
    for repetition in $(seq "$repetitions"); do
      for model in hertz mindlin jkr; do
        for program in spall lammps liggghts; do
          [ "$program" != liggghts ] || { [ -n "$liggghts" ] && [ $model = hertz ]; } || continue
          result=$(run $program $model $data.data "$ranks" || true)
          [ "$(wc -w <<<"$result")" = 3 ] || continue
          read -r speed share bytes <<<"$result"
          by_processor=$(awk -v a="$speed" -v b="$share" 'BEGIN {printf "%.4g", a / b}')
          echo "$data,$model,$ranks,$repetition,$program,$speed,$share,$by_processor,$bytes" | tee -a all.csv
        done
      done
    done
  done
done
echo
echo "ratios of the medians, spall over the other"
awk -F, '{k = $1 "," $2 "," $3 "," $5; n[k]++; wall[k, n[k]] = $6; cpu[k, n[k]] = $8; bytes[k] = $9}
  function median(a, k,   i, j, m, t, v) {
    m = n[k]; for (i = 1; i <= m; i++) v[i] = a[k, i]
    for (i = 1; i <= m; i++) for (j = i + 1; j <= m; j++) if (v[j] < v[i]) {t = v[i]; v[i] = v[j]; v[j] = t}
    return v[int((m + 1) / 2)]
  }
  END {for (k in n) {split(k, f, ","); if (f[4] == "spall") continue; s = f[1] "," f[2] "," f[3] ",spall"
    printf "%s %s, %s rank(s), against %s: wall %.2f, processor time %.2f, memory %.2f\n",
      f[1], f[2], f[3], f[4], median(wall, s) / median(wall, k), median(cpu, s) / median(cpu, k),
      bytes[s] / bytes[k]}}' all.csv | sort
