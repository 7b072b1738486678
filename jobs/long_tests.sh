#!/usr/bin/env bash
# Tests that take longer than those of jobs/test.sh: more faults, on more ranks, fuzzing, valgrind, the kernels without
# vectors, all tests under sanitizers, the Debian packages, and pip. Hours on two cores.
# As root also full disks: filling one takes a mount. What they say is kept in build/long_tests, one folder a run, by date and commit.
# usage: long_tests.sh [COUNT [RANKS…]]    so many kills over three numbers of ranks, and writers killed, and ranks that end;
#                                          seventeen times as many errors, half as many disks, ten times as many seconds a fuzzer; default: 60 on 1 2 4
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"

kept=build/long_tests/$(date +%Y-%m-%d_%H%M)_$(bench/commit.sh)
mkdir -p "$kept"
exec > >(tee "$kept/output.log") 2>&1

count=${1:-60}
[ $# -gt 1 ] && shift || set -- 1 2 4
build=build/release
failures=0
for ranks in "$@"; do
  for what in disks kills writers ends errors; do
    case $what in
      kills | writers | ends) draws=$count ;;
      errors) draws=$((count * 17)) ;;
      disks) [ "$(id -u)" -eq 0 ] && draws=$((count / 2)) || continue ;;
    esac
    /usr/bin/python3 tests/faults/faults.py $what "$PWD/$build/spall" "$(command -v mpirun)" cases "$build/faults_${what}_$ranks" \
      --disk "$PWD/$build/tests/libfailing_disk.so" --ranks "$ranks" --count $((draws / 3)) --seed "$ranks" ||
      failures=$((failures + 1))
  done
done
/usr/bin/python3 tests/fuzz/fuzz.py "$build" $((count * 10)) || failures=$((failures + 1))
tests/valgrind.sh "$build" || failures=$((failures + 1))
# The kernels without vectors, the reference of those with: all tests of physics on 1 and 2 ranks.
cmake --preset scalar -DSPALL_BENCH=OFF
cmake --build --preset scalar
ctest --test-dir build/scalar --output-on-failure --parallel "$(nproc)" -R '_[12]$' || failures=$((failures + 1))
jobs/sanitized.sh || failures=$((failures + 1))
mkdir "$kept/packages"
packaging/try_debian.sh "$kept/packages" || failures=$((failures + 1))
jobs/try_pip.sh || failures=$((failures + 1))
exit $((failures > 0))
