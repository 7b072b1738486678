#!/bin/sh
# Runs the scaling benchmark on 1, 2 … ranks in turns into bench/results/scaling.csv and puts the
# table into bench/README.md. About eight minutes on two quiet cores.
# usage: bench/run_scaling.sh BUILD_FOLDER [RANKS …], for example build/release 1 2 4
# SPDX-License-Identifier: BSD-3-Clause
set -eu
build=$1
shift
[ $# -gt 0 ] || set -- 1 2
here=$(dirname "$0")
mkdir -p "$here/results"
csv=$here/results/scaling.csv
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
echo "# commit $("$here"/commit.sh), $(date +%F), $(sed -n 's/^model name.*: //p' /proc/cpuinfo | head -n 1), $(nproc) cores" > "$csv"
echo "scene,ranks,bodies,contacts,seconds,unit,error,peak_MB" >> "$csv"
for round in ${ROUNDS:-1 2 3}; do
  for scene in lattice nucleus plate gravity; do
    for ranks in "$@"; do
      mpirun --oversubscribe -n "$ranks" "$build/bench/bench_scaling" $scene >> "$csv"
    done
  done
done
/usr/bin/python3 "$here/write_scaling.py" "$csv"
