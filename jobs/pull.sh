#!/usr/bin/env bash
# The four aggregates of cases/pull, their table and the picture of the forces.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"

for count in 2 8 64 512; do
  mpirun -n "${RANKS:-1}" build/release/spall run "cases/pull/$count.toml" --out "out/pull-$count" --overwrite
done
/usr/bin/python3 cases/pull/picture.py out
