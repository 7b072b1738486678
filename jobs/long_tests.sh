#!/usr/bin/env bash
# Tests that take longer than those of jobs/test.sh: more faults, on more ranks, and fuzzing. Hours on two cores.
# usage: long_tests.sh [COUNT]    so many kills; sixteen times as many errors, ten times as many seconds a fuzzer
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"

count=${1:-60}
build=build/release
for ranks in 1 2 4; do
  for what in kills errors; do
    draws=$count
    [ $what = kills ] || draws=$((count * 16))
    python3 tests/faults/faults.py $what "$PWD/$build/spall" "$(command -v mpirun)" cases "$build/faults_$what" \
      --disk "$PWD/$build/tests/libfailing_disk.so" --ranks $ranks --count $((draws / 3 + 1)) --seed $ranks
  done
done
/usr/bin/python3 tests/fuzz/fuzz.py "$build" $((count * 10))
