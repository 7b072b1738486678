#!/usr/bin/env bash
# Aluminium by its material's law against what is known of it (bench_solid); writes bench/results/solid.csv and its
# tables into bench/README.md. Some twenty minutes on two cores; `run_solid.sh build/release 10` is coarser.
set -euo pipefail
cd "$(dirname "$0")/.."
source jobs/environment.sh
build=${1:-build/release} length=${2:-14}
run() { mpirun -n "${RANKS:-2}" "$build/bench/bench_solid" cases/plate/case.toml "$@"; }
{
  echo "what,orientation,speed,measured,second,wanted,third"
  for up in 500 1000 2000 3350; do
    for orientation in 100 110 111 1 2 3 4; do run shock $orientation 0.5 $up "$length"; done
  done
  for orientation in 100 110 111 1 2; do run tension $orientation 0.5; done
  for orientation in 100 110 111 1 2; do run spall $orientation 0.5 500 6; done
} | tee bench/results/solid.csv
/usr/bin/python3 bench/plot_solid.py
