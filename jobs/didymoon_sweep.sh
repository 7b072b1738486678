#!/usr/bin/env bash
# Aggregates of three seeds, each hit once for each cohesion in N (default: the thesis's seven), and the first also with cohesion as the
# thesis's engine reads it; writes cases/didymoon/results.md, sweep.csv and sweep.png. What an earlier sweep left in out/ is kept:
# FRESH=1 moves it aside first, to run and time all of it.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"

[ $# -gt 0 ] || set -- 100 200 300 400 500 1000 2000
cohesions=("$@")
sweep=out/didymoon-sweep
[ -z "${FRESH:-}" ] || [ ! -e $sweep ] || mv $sweep "$sweep-before-$(date +%s)"
spall="mpirun -n ${RANKS:-2} ${MPI_OPTIONS:-} ${SPALL:-build/release/spall}"
hit() {  # reading of cohesion, seed
  local pile=$sweep/pile$2 c run
  [ -f "$pile/after_aggregation.h5" ] || $spall run cases/didymoon/case.toml --out "$pile" --overwrite --set "seed=$2"
  for c in "${cohesions[@]}"; do
    run=$sweep/$1-seed$2-$c
    [ -f "$run/results.toml" ] || $spall resume "$pile/after_aggregation.h5" --out "$run" --overwrite --set "phases.impact.cohesion=$c N" \
      --set "contact.cohesion_law=$1"
  done
}
hit force 1
hit force 2
hit force 3
hit impulse 1
/usr/bin/python3 cases/didymoon/sweep.py $sweep
