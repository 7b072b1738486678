#!/usr/bin/env bash
# Aggregates of the seeds in SEEDS (default: 1 2 3), each hit once for each cohesion in N (default: the thesis's seven), as a force
# and as the thesis's engine reads it; writes cases/didymoon/results.md, sweep.csv and sweep.png. What an earlier sweep left in out/
# is kept: FRESH=1 moves it aside first, to run and time all of it.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"

[ $# -gt 0 ] || set -- 100 200 300 400 500 1000 2000
sweep=out/didymoon-sweep
[ -z "${FRESH:-}" ] || [ ! -e $sweep ] || mv $sweep "$sweep-before-$(date +%s)"
spall="mpirun -n ${RANKS:-2} ${MPI_OPTIONS:-} ${SPALL:-build/release/spall}"
for law in force impulse; do
  for seed in ${SEEDS:-1 2 3}; do
    pile=$sweep/pile$seed
    [ -f "$pile/after_aggregation.h5" ] || $spall run cases/didymoon/case.toml --out "$pile" --set "seed=$seed"
    for c in "$@"; do
      run=$sweep/$law-seed$seed-$c
      [ -f "$run/results.toml" ] || $spall resume "$pile/after_aggregation.h5" --out "$run" --set "phases.impact.cohesion=$c N" \
        --set "contact.cohesion_law=$law"
    done
  done
done
/usr/bin/python3 cases/didymoon/sweep.py $sweep
