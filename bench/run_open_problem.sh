#!/bin/sh
# Solves the contact problem of a pile of 10,000 that has just settled, and 400 steps later, in several
# ways into bench/results/open_problem.csv, draws it and puts a table into bench/README.md. About ten minutes.
# usage: bench/run_open_problem.sh BUILD_FOLDER [BODIES]
# SPDX-License-Identifier: BSD-3-Clause
set -eu
here=$(dirname "$0")
mkdir -p "$here/results"
csv=$here/results/open_problem.csv
echo "# ${2:-10000} bodies, commit $("$here"/commit.sh), $(date +%F)" > "$csv"
"$1/bench/bench_open_problem" "${2:-10000}" >> "$csv"
/usr/bin/python3 "$here/plot_open_problem.py" "$csv"
