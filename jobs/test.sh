#!/usr/bin/env bash
# Installs, builds and runs all tests on 1, 2, 3 and 4 ranks. Arguments go to ctest, as in -R solver.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"

jobs/packages.sh
cmake --preset release -DSPALL_TESTS=ON -DSPALL_BENCH=ON
cmake --build --preset release
ctest --test-dir build/release --output-on-failure --parallel "$(nproc)" "$@"
