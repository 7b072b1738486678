#!/usr/bin/env bash
# Builds with the address and undefined-behaviour sanitizers and runs tests on one and two ranks.
# The longest tests, which tread no ground of their own, are left out. MPI, PETSc and HDF5 keep memory
# to the end on purpose: leaks are not looked for.
# SPDX-License-Identifier: BSD-3-Clause
# usage: sanitized.sh [short]    short: tests that tread most of the code between them, a third of the time
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"

cmake --preset sanitize -DSPALL_BENCH=OFF
export GTEST_FILTER='-Aggregate*:Orbits*:SolidShock.*:PorousShock.has*:*bond_holds*:*haff*' ASAN_OPTIONS=detect_leaks=0
if [ "${1:-}" = short ]; then
  on_one=(units case packing solid_bodies)
  on_two=(scene domain ghosts gravity_tree solver step clumps potential penalty two_solids brittle hand_over output debris)
  cmake --build --preset sanitize --target "${on_one[@]/#/test_}" "${on_two[@]/#/test_}"
  tests="^($(IFS='|'; echo "${on_one[*]}"))_1\$|^($(IFS='|'; echo "${on_two[*]}"))_2\$"
else
  cmake --build --preset sanitize
  tests='^(units|case|packing|solid_bodies)_1$|_2$'
fi
ctest --test-dir build/sanitize --output-on-failure -R "$tests" -E corpus_by_program
