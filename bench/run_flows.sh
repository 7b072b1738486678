#!/bin/bash
# A silo's saturated load (Janssen) and the profile of LAMMPS's chute flow (Silbert), by Spall and by LAMMPS from the same
# start files; writes README.md's table.
# SPDX-License-Identifier: BSD-3-Clause
# usage: run_flows.sh [BUILD [SEEDS [FOLDER]]]; FOLDER keeps the runs, whose results are not made anew; LAMMPS_FOLDER as of
# run_untuned.sh. Half an hour.
set -eu
. "$(dirname "$(realpath "$0")")/beside_peers.sh"
spall=$(realpath "${1:-build/release}")/spall
seeds=${2:-3}
work_in "${3:-}"
native=$("$here/peers/build_lammps.sh" "${LAMMPS_FOLDER:-lammps}")
cp "$(dirname "$native")"/../bench/{data.chute,in.chute} "$here"/flows/*.toml "$here"/untuned/chute.toml .

# case, data file, folder, more options of spall
run_case() {
  start_from "$2" "$1"
  "$spall" run "$1.toml" --out "$3" --overwrite "${start[@]}" "${@:4}" >/dev/null
}

for seed in $(seq "$seeds"); do
  /usr/bin/python3 "$here/flows/make_silo.py" "$seed" silo.data
  [ -f "silo$seed.log" ] || { "$native" -in "$here/flows/silo.in" -var data silo.data -log part.log >/dev/null && mv part.log "silo$seed.log"; }
  [ -f "silo$seed/results.toml" ] || run_case silo silo.data "silo$seed"
done
# Twice by each, with other roundings: how far they part tells what the means are worth.
for peer in "1 $native" "2 $lmp"; do
  read -r run program <<<"$peer"
  [ ! -f chute$run.log ] || continue
  sed -e "s/^run.*/dump flow active custom 2500 chute$run.dump id z vx\nrun 50000/" in.chute >chute.in
  "$program" -in chute.in -log part.log >/dev/null
  mv part.log chute$run.log
done
for level in "1 v4" "2 v2"; do
  read -r run instructions <<<"$level"
  [ -f chute$run/results.toml ] || SPALL_INSTRUCTIONS=$instructions run_case chute data.chute chute$run \
    --set phases.0.duration=5 --set output.snapshot_every=0.25
done
/usr/bin/python3 "$here/flows/compare.py" "$seeds"
