#!/usr/bin/env bash
# Tilts trays of each shape, with three packings each, and writes README.md's table.
# usage: [OUT=out] cases/tilt/tilt.sh [SPALL]; runs that are there already are kept
# SPDX-License-Identifier: BSD-3-Clause
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
spall=${1:-build/release/spall}
out=${OUT:-out}
mkdir -p "$out"
table=()

# run LABEL NAME SHAPE RADIUS [KEY=VALUE …]: for all seeds. All shapes have the volume of a ball
# of 1 m; the radius is that of the sphere around them.
run() {
  local label=$1 name=$2 shape=$3 radius=$4 folders="" seed
  shift 4
  for seed in $seeds; do
    local folder=$out/tilt_${name}_$seed
    [ -e "$folder/results.toml" ] ||
      "$spall" run cases/tilt/case.toml --set seed=$seed "groups.boulders.packing.shape=$shape" \
        "groups.boulders.packing.radius=$radius" "$@" --out "$folder" > "$folder.log"
    folders+=${folders:+,}$folder
  done
  table+=("$label=$folders")
}

seeds="1 2 3"
run "balls" ball ball 0.5m
run "2 : √2 : 1, of 7 balls" boulder boulder 0.8257m
run "2 : √2 : 1, of 15 balls" finer_boulder finer_boulder 0.74m
run "tetrapods of 4 balls" tetrapod tetrapod 0.6381m
run "2 : √2 : 1, of 7 balls, friction 0.25" boulder_smooth boulder 0.8257m contact.friction=0.25
run "2 : √2 : 1, of 7 balls, friction 1" boulder_rough boulder 0.8257m contact.friction=1
# What should not matter, beside the first packing of the second row.
seeds=1
run "of 7 balls, the first of its three" boulder boulder 0.8257m
run "the same, steps of 5 ms" boulder_short boulder 0.8257m phases.tilt.step=5ms
run "the same, no proximal term" boulder_prox boulder 0.8257m solver.prox=0
cases/tilt/angles.py "${table[@]}"
