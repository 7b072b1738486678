#!/bin/sh
# Ghosts and imbalance of both cuts of the domain, into bench/results/partition.csv and README.md.
# usage: bench/run_partition.sh BUILD_FOLDER [RANKS …], for example build/release 2 3 4 16
# SPDX-License-Identifier: BSD-3-Clause
set -eu
build=$1
shift
[ $# -gt 0 ] || set -- 2 3 4 16
here=$(dirname "$0")
csv=$here/results/partition.csv
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
echo "# commit $("$here"/commit.sh), $(date +%F)" > "$csv"
echo "shape,bodies,ranks,cut,ghosts_mean,ghosts_most,imbalance" >> "$csv"
for ranks in "$@"; do
  mpirun --oversubscribe -n "$ranks" "$build/bench/bench_partition" >> "$csv"
done
/usr/bin/python3 "$here/write_partition.py" "$csv"
