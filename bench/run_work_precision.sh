#!/bin/sh
# Runs every solver method on three generated scenes into bench/results/work_precision.csv, draws it
# and puts the table into bench/README.md. About ten minutes on one core.
# usage: bench/run_work_precision.sh BUILD_FOLDER [SCENE …], scenes: pile nucleus plate
# SPDX-License-Identifier: BSD-3-Clause
set -eu
build=$1
shift
here=$(dirname "$0")
mkdir -p "$here/results"
csv=$here/results/work_precision.csv
echo "# commit $("$here"/commit.sh), $(date +%F), $(sed -n 's/^model name.*: //p' /proc/cpuinfo | head -n 1), $(nproc) cores" > "$csv"
"$build/bench/bench_work_precision" "$@" >> "$csv"
/usr/bin/python3 "$here/plot_work_precision.py" "$csv"
