#!/bin/sh
# What `spall plan` foretells beside what runs have, into bench/results/plan.csv and README.md.
# usage: bench/run_plan.sh BUILD_FOLDER [RANKS ...], for example build/release 1 2 4 16 64
# SPDX-License-Identifier: BSD-3-Clause
set -eu
build=$1
shift
[ $# -gt 0 ] || set -- 1 2 4 16 64
here=$(dirname "$0")
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_mpi_yield_when_idle=1
/usr/bin/python3 "$here/compare_plan.py" "$build/spall" "$here/results/plan.csv" "$@"
