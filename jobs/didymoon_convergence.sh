#!/usr/bin/env bash
# How the impact of cases/didymoon depends on step, tolerance and range of cohesion: 10,307 boulders, 500 N, all from the sweep's
# first aggregate (jobs/didymoon_sweep.sh makes it, and the scatter of seeds to compare with); writes cases/didymoon/convergence.md.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"

spall="${SPALL:-build/release/spall}"
pile=out/didymoon-sweep/pile1 out=out/didymoon-convergence
[ -f $pile/after_aggregation.h5 ] || mpirun -n "${RANKS:-2}" "$spall" run cases/didymoon/case.toml --out $pile --overwrite --set seed=1
run() {
  local name=$1 ranks=$2
  shift 2
  [ -f "$out/$name/results.toml" ] || mpirun -n "$ranks" "$spall" resume $pile/after_aggregation.h5 --out "$out/$name" --overwrite "$@"
}
step=phases.impact.step tolerance=phases.impact.solver.tolerance
run base 2
run one-rank 1
run step-2 2 --set $step=0.2ms
run step-0.5 2 --set $step=0.05ms
run step-0.25 2 --set $step=0.025ms
run later-0.5 2 --set phases.evolution-fine.step=0.05s --set phases.evolution.step=0.5s
run tolerance-1e-3 2 --set $tolerance=1e-3
run tolerance-all 2 --set $tolerance=1e-3 --set phases.evolution-fine.solver.tolerance=1e-3 --set phases.evolution.solver.tolerance=1e-3
run range-0.5 2 --set "contact.cohesion_range=0.5 cm"
run range-2 2 --set "contact.cohesion_range=2 cm"
/usr/bin/python3 cases/didymoon/convergence.py $out
