#!/usr/bin/env bash
# Times the main job and a step of its settled pile on 2 ranks; writes what it measured into README.md
# and bench/README.md. Takes about three minutes on a machine with nothing else to do.
# SPDX-License-Identifier: BSD-3-Clause
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../jobs/environment.sh"

mpirun -n 2 build/release/spall run cases/didymoon/case.toml --out out/didymoon --overwrite
mpirun -n 2 build/release/bench/bench_settled_step out/didymoon/after_aggregation.h5 \
  >bench/results/settled_step.csv
/usr/bin/python3 bench/write_main_job.py out/didymoon
