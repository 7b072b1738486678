#!/usr/bin/env bash
# Tests on 2 ranks under valgrind, which also looks at what goes into MPI calls (valgrind-mpi).
# usage: valgrind.sh BUILD [TEST …]
# SPDX-License-Identifier: BSD-3-Clause
set -euo pipefail
build=$(cd "$1" && pwd)
shift
[ $# -gt 0 ] || set -- ghosts domain step output
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
wrapper=$(ls /usr/lib/*/valgrind/libmpiwrap-*.so)
mpi=$(ldd "$build/tests/test_$1" | awk '$1 ~ /^libmpi\.so/ {print $3}')  # the wrapper does not name it
# Kernels for AVX-512 are beyond valgrind. Its own script would load the wrapper into a shell.
export SPALL_INSTRUCTIONS=v2 MPIWRAP_DEBUG=quiet
cd "$build/tests"  # tests write beside themselves, as under ctest
failures=0
for name in "$@"; do
  echo "valgrind: $name"
  mpirun --oversubscribe -n 2 env LD_PRELOAD="$mpi:$wrapper" /usr/bin/valgrind.bin --quiet --error-exitcode=9 \
    --suppressions="$here/valgrind.supp" --suppressions=/usr/share/openmpi/openmpi-valgrind.supp \
    "$build/tests/test_$name" || failures=$((failures + 1))
done
exit $((failures > 0))
