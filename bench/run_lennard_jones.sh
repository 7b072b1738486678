#!/bin/bash
# The impact of a Lennard-Jones solid side by side with LAMMPS, from one start file, in turns.
# SPDX-License-Identifier: BSD-3-Clause
# usage: run_lennard_jones.sh [BUILD [REPETITIONS [STEPS]]]; about 2 minutes a repetition on a quiet machine
set -eu
bench=$(realpath "${1:-build/release}")/bench/bench_lennard_jones
repetitions=${2:-3} steps=${3:-60}
lmp=$(command -v lmp || command -v lammps || true)
[ -x /usr/bin/time ] || { echo "skipped: /usr/bin/time is not installed (apt-get install time)"; exit 0; }
[ -n "$lmp" ] || { echo "skipped: LAMMPS is not installed (apt-get install lammps)"; exit 0; }
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMP_NUM_THREADS=1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"$bench" 1.5 1 1 1 start.data
cat >impact.in <<'END'
units lj
atom_style atomic
boundary s s s
newton on
read_data start.data
pair_style ${style} ${cutoff}
pair_modify shift yes
pair_coeff 1 1 1.0 1.0
neighbor 0.3 bin
neigh_modify delay 0 every 1 check yes
timestep 0.002
fix 1 all nve
thermo ${steps}
thermo_style custom step pe ke
thermo_modify norm yes format float %.12g
run 60
run ${steps}
END
bodies=$(awk '/atoms/ {print $1; exit}' start.data)

# program, cutoff, ranks -> "million steps a second, share of a processor, bytes a body"
run() {
  local program=$1 cutoff=$2 ranks=$3
  if [ "$program" = spall ]; then
    mpirun --oversubscribe -n "$ranks" "$bench" "$cutoff" "$steps" 1 >out
    awk '/^bodies/ {print $6, ($9 > 0 ? $6 / $9 : 1), $(NF - 4)}' out
    awk '/^potential/ {print $2, $4}' out >"energy.${program//\//_}"
  else
    mpirun --oversubscribe -n "$ranks" /usr/bin/env bash -c \
      '/usr/bin/time -f "%M kB" "$@"' bash "$lmp" -in impact.in -var style "$program" \
      -var cutoff "$cutoff" -var steps "$steps" >out 2>err
    awk -v n="$bodies" -v steps="$steps" '/^Loop time/ {t = $4} /CPU use/ {share = $1 / 100}
      END {printf "%.4g %.3g ", 1e-6 * n * steps / t, share}' out
    awk -v n="$bodies" '/ kB$/ {sum += $1} END {printf "%.4g\n", 1024 * sum / n}' err
    awk -v last=$((60 + steps)) '$1 == last {print $2, $3; exit}' out >"energy.${program//\//_}"
  fi
}

echo "cutoff,ranks,repetition,program,million_steps_s,share_of_processor,million_steps_processor_s,bytes_a_body"
for cutoff in 1.5 2.5; do
  for ranks in 1 2; do
    for repetition in $(seq "$repetitions"); do
      for program in spall lj/cut lj/cut/opt; do
        # Not every LAMMPS has the package with the second style.
        result=$(run "$program" "$cutoff" "$ranks" || true)
        [ "$(wc -w <<<"$result")" = 3 ] || continue
        read -r speed share bytes <<<"$result"
        by_processor=$(awk -v a="$speed" -v b="$share" 'BEGIN {printf "%.4g", a / b}')
        echo "$cutoff,$ranks,$repetition,$program,$speed,$share,$by_processor,$bytes" | tee -a all.csv
      done
    done
  done
  echo "energies a body after $((60 + steps)) steps, potential and kinetic: spall $(cat energy.spall), lj/cut $(cat energy.lj_cut)"
done
echo
echo "ratios of the medians, spall over the other"
awk -F, '{k = $1 "," $2 "," $4; n[k]++; wall[k, n[k]] = $5; cpu[k, n[k]] = $7; bytes[k] = $8}
  function median(a, k,   i, j, m, t, v) {
    m = n[k]; for (i = 1; i <= m; i++) v[i] = a[k, i]
    for (i = 1; i <= m; i++) for (j = i + 1; j <= m; j++) if (v[j] < v[i]) {t = v[i]; v[i] = v[j]; v[j] = t}
    return v[int((m + 1) / 2)]
  }
  END {for (k in n) {split(k, f, ","); if (f[3] == "spall") continue; s = f[1] "," f[2] ",spall"
    printf "cutoff %s, %s rank(s), against %s: wall %.2f, processor time %.2f, memory %.2f\n",
      f[1], f[2], f[3], median(wall, s) / median(wall, k), median(cpu, s) / median(cpu, k),
      bytes[s] / bytes[k]}}' all.csv | sort
