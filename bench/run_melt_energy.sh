#!/bin/bash
# The energy of LAMMPS's melt over many steps, by Spall and by LAMMPS from one start; writes README.md's table.
# SPDX-License-Identifier: BSD-3-Clause
# usage: run_melt_energy.sh FOLDER [BUILD [STEPS]]; FOLDER has the start files of run_untuned.sh
set -eu
folder=$(realpath "$1")
. "$(dirname "$(realpath "$0")")/beside_peers.sh"
spall=$(realpath "${2:-build/release}")/spall
steps=${3:-10000}
cd "$folder"
start_from melt.data melt
"$spall" run melt.toml --out melt_energy.out --overwrite "${start[@]}" \
  --set "phases.0.duration=$(awk -v n="$steps" 'BEGIN {print 0.005 * n}')" >/dev/null
# Spall counts a pair's energy from where it is cut, LAMMPS only if asked: without, a pair that comes within the
# cutoff changes the sum by what no force has done.
unchecked="every 20 check no" # as in.lj says
checked="every 1 check yes"
# name, shift, how lists are kept
run_lammps() {
  sed -e "s#lj/cut#lj/cut/opt#; s/^neighbor/pair_modify shift $2\nneighbor/; s/^neigh_modify.*/neigh_modify delay 0 $3/" \
    -e "s/^run.*//" in.lj >melt_energy.in
  printf '%s\n' "thermo 100" "thermo_style custom step etotal" "thermo_modify norm yes format float %.15g" \
    "run $steps" >>melt_energy.in
  "$lmp" -in melt_energy.in -log "melt_energy_$1.log" >/dev/null
}
run_lammps plain no "$unchecked"
run_lammps shifted yes "$unchecked"
run_lammps checked yes "$checked"
/usr/bin/python3 "$here/melt_energy.py" melt_energy.out/series.csv melt_energy_plain.log \
  melt_energy_shifted.log melt_energy_checked.log
