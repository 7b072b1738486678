#!/usr/bin/env bash
# Runs what is missing in out/ of the scenes nucleus, dart, spin, merge and tides and writes their tables and pictures beside them.
# Arguments: the scenes to run (default: all five).
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"

[ $# -gt 0 ] || set -- spin merge tides nucleus dart
[ -f out/pile/after_settling.h5 ] || mpirun -n 2 build/release/spall run cases/pile/case.toml --out out/pile --overwrite
for scene in "$@"; do
  SECONDS=0
  /usr/bin/python3 "cases/$scene/run.py"
  echo "$scene: $SECONDS s"
done
