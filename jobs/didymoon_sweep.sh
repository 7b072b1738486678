#!/usr/bin/env bash
# One aggregate (that of out/didymoon, where a run left it), hit once for each cohesion in N (default: 500 2000);
# writes cases/didymoon/results.md.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"

[ $# -gt 0 ] || set -- 500 2000
[ -f out/didymoon/after_aggregation.h5 ] ||
  mpirun -n 2 build/release/spall run cases/didymoon/case.toml --out out/didymoon
folders=()
for c in "$@"; do
  mpirun -n 2 build/release/spall resume out/didymoon/after_aggregation.h5 \
    --out "out/didymoon-$c" --set "phases.impact.cohesion=$c N"
  folders+=("out/didymoon-$c")
done

table=$(/usr/bin/python3 cases/didymoon/table.py "${folders[@]}")
cat >cases/didymoon/results.md <<END
# Didymoon: the impacts, beside the thesis
Written by \`jobs/didymoon_sweep.sh $*\` at commit $(git describe --always --dirty), $(date +%F), on 2 ranks.

$table
END
