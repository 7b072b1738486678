#!/bin/bash
# The impact of a Lennard-Jones solid side by side with LAMMPS, from one start file, in turns; writes README.md's table.
# SPDX-License-Identifier: BSD-3-Clause
# usage: run_lennard_jones.sh [BUILD [REPETITIONS [STEPS [SCALE]]]]; about 2 minutes a repetition on a quiet machine; SCALE: of
# the plate's width
set -eu
. "$(dirname "$(realpath "$0")")/beside_peers.sh"
bench=$(realpath "${1:-build/release}")/bench/bench_lennard_jones
repetitions=${2:-3} steps=${3:-60} scale=${4:-1}
work_in ""
"$bench" 1.5 1 1 "$scale" start.data
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

begin_records
for cutoff in 1.5 2.5; do
  for ranks in 1 2; do
    for repetition in $(seq "$repetitions"); do
      record "$cutoff sigma" $ranks "$repetition" spall "$(run_spall $ranks "$bench" $cutoff "$steps" 1 "$scale")"
      energy=$(awk '/^potential/ {print $2, $4}' out)
      for style in lj/cut lj/cut/opt; do
        record "$cutoff sigma" $ranks "$repetition" "${style/lj/lammps}" "$(run_peer "$bodies" "$steps" $ranks "$lmp" -in impact.in \
          -var style $style -var cutoff $cutoff -var steps "$steps" || true)"
        [ $style != lj/cut ] || theirs=$(awk -v last=$((60 + steps)) '$1 == last {print $2, $3; exit}' out)
      done
    done
  done
  echo "energies a body after $((60 + steps)) steps, potential and kinetic: spall $energy, lj/cut $theirs"
done
write_records lennard_jones
