#!/usr/bin/env bash
# Tests that take longer than those of jobs/test.sh: more faults, on more ranks, fuzzing, valgrind, the Debian packages, pip. Hours on two cores.
# As root also full disks: filling one takes a mount.
# usage: long_tests.sh [COUNT [RANKS…]]    so many kills over three numbers of ranks; seventeen times as many errors, half as
#                                          many disks, ten times as many seconds a fuzzer; default: 60 on 1 2 4
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"

count=${1:-60}
[ $# -gt 1 ] && shift || set -- 1 2 4
build=build/release
failures=0
for ranks in "$@"; do
  for what in disks kills errors; do
    case $what in
      kills) draws=$count ;;
      errors) draws=$((count * 17)) ;;
      disks) [ "$(id -u)" -eq 0 ] && draws=$((count / 2)) || continue ;;
    esac
    python3 tests/faults/faults.py $what "$PWD/$build/spall" "$(command -v mpirun)" cases "$build/faults_${what}_$ranks" \
      --disk "$PWD/$build/tests/libfailing_disk.so" --ranks "$ranks" --count $((draws / 3)) --seed "$ranks" ||
      failures=$((failures + 1))
  done
done
/usr/bin/python3 tests/fuzz/fuzz.py "$build" $((count * 10)) || failures=$((failures + 1))
tests/valgrind.sh "$build" || failures=$((failures + 1))
packaging/try_debian.sh || failures=$((failures + 1))
jobs/try_pip.sh || failures=$((failures + 1))
exit $((failures > 0))
