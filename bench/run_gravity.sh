#!/bin/sh
# Runs the gravity benchmark on 1 and 2 ranks into bench/results/gravity.csv, then draws it.
# usage: bench/run_gravity.sh BUILD_FOLDER [SETS [RANKS]], for example build/release "ball:10307" "1 2"
# SPDX-License-Identifier: BSD-3-Clause
set -eu
build=$1
sets=${2:-"ball:10307 ball:100000 plummer:100000 pile:100000 ball:1000000 ball:4000000"}
counts=${3:-"1 2"}
here=$(dirname "$0")
mkdir -p "$here/results"
csv=$here/results/gravity.csv
echo "# commit $("$here"/commit.sh), $(date +%F), $(sed -n 's/^model name.*: //p' /proc/cpuinfo | head -n 1), $(nproc) cores" > "$csv"
echo "set,bodies,ranks,order,asked,rms,p99,max,tree_s,build_s,exchange_s,direct_s,plain_s,bytes,net_force,net_torque" >> "$csv"
for set in $sets; do
  for ranks in $counts; do
    mpirun --oversubscribe -n $ranks "$build/bench/bench_gravity" "${set%:*}" "${set#*:}" >> "$csv"
  done
done
/usr/bin/python3 "$here/plot_gravity.py" "$csv"
