#!/usr/bin/env bash
# From a fresh Debian 12 machine to the deflected asteroid: install, build, run, report.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"

jobs/packages.sh
cmake --preset release -DSPALL_TESTS=OFF -DSPALL_BENCH=OFF
cmake --build --preset release
mpirun -n 2 build/release/spall run cases/didymoon/case.toml --out out/didymoon --overwrite
build/release/spall report out/didymoon
