#!/bin/bash
# A silo's saturated load (Janssen) and the profile of a flow down a slope (Silbert), by Spall and by LAMMPS from the
# same start files; writes README.md's table.
# SPDX-License-Identifier: BSD-3-Clause
# usage: run_flows.sh [BUILD [SEEDS [FOLDER]]]; FOLDER keeps the runs, whose results are not made anew. Half an hour.
set -eu
. "$(dirname "$(realpath "$0")")/beside_peers.sh"
spall=$(realpath "${1:-build/release}")/spall
seeds=${2:-3}
work=${3:-$(mktemp -d)}
mkdir -p "$work"
[ $# -ge 3 ] || trap 'rm -rf "$work"' EXIT
cd "$work"
cp "$here"/flows/*.toml .
for scene in silo slope; do
  steps=200000
  [ $scene = silo ] || steps=1400000
  for seed in $(seq "$seeds"); do
    of=$scene$seed
    /usr/bin/python3 "$here/flows/make_flow.py" $scene "$seed" $scene.data
    if [ ! -f "$of.log" ]; then
      "$lmp" -in "$here/flows/$scene.in" -var data $scene.data -var steps $steps -log part.log >/dev/null
      [ $scene = silo ] || mv slope.dump "$of.dump"
      mv part.log "$of.log"
    fi
    [ ! -f "$of/results.toml" ] || continue
    words=()
    while read -r option; do words+=(--set "${option#--set }"); done \
      < <(/usr/bin/python3 "$here/untuned/data_to_restart.py" $scene.data $scene)
    "$spall" run $scene.toml --out "$of" --overwrite "${words[@]}" >/dev/null
  done
done
/usr/bin/python3 "$here/flows/compare.py" "$seeds"
