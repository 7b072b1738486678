#!/usr/bin/env bash
# How the impact of cases/didymoon depends on step, tolerance and range of cohesion, at 1,000 boulders (a tenth of the body, of
# the impactor and of the cohesion), and under the thesis's reading of cohesion; writes cases/didymoon/convergence.md.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"

spall="mpirun -n ${RANKS:-2} ${MPI_OPTIONS:-} ${SPALL:-build/release/spall}"
out=out/didymoon-convergence
small=(--set groups.cloud.packing.count=1000 --set "groups.cloud.volume.radius=43.7 m"
       --set "phases.impact.impactor.mass=50 kg" --set "phases.aggregation.settled_speed=0.02 mm/s")
[ -f $out/pile/after_aggregation.h5 ] || $spall run cases/didymoon/case.toml --out $out/pile "${small[@]}"
run() {
  local name=$1
  shift
  [ -f "$out/$name/results.toml" ] || $spall resume $out/pile/after_aggregation.h5 --out "$out/$name" --set "phases.impact.cohesion=50 N" "$@"
}
step=phases.impact.step tolerance=phases.impact.solver.tolerance
run base
run step-2 --set $step=0.2ms
run step-0.5 --set $step=0.05ms
run step-0.25 --set $step=0.025ms
run tolerance-1e-3 --set $tolerance=1e-3
run range-0.5 --set "contact.cohesion_range=0.5 cm"
run range-2 --set "contact.cohesion_range=2 cm"
run impulse --set contact.cohesion_law=impulse
/usr/bin/python3 cases/didymoon/convergence.py $out
