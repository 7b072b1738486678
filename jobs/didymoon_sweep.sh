#!/usr/bin/env bash
# Aggregates of the seeds in SEEDS (default: 1 2 3), each hit once for each cohesion in N (default: the thesis's
# seven); writes cases/didymoon/results.md, sweep.csv and sweep.png. What an earlier sweep left in out/ is kept.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"

[ $# -gt 0 ] || set -- 100 200 300 400 500 1000 2000
spall="mpirun -n ${RANKS:-2} ${SPALL:-build/release/spall}"
for seed in ${SEEDS:-1 2 3}; do
  # The aggregate of out/didymoon is that of seed 1.
  pile=out/didymoon$([ "$seed" = 1 ] || echo "-seed$seed")
  [ -f "$pile/after_aggregation.h5" ] ||
    $spall run cases/didymoon/case.toml --out "$pile" --set "seed=$seed"
  for c in "$@"; do
    run=out/didymoon-sweep/seed$seed-$c
    [ -f "$run/results.toml" ] ||
      $spall resume "$pile/after_aggregation.h5" --out "$run" --set "phases.impact.cohesion=$c N"
  done
done
/usr/bin/python3 cases/didymoon/sweep.py out/didymoon-sweep
