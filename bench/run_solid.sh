#!/usr/bin/env bash
# Aluminium by its material's law against what is known of it (bench_solid); writes bench/results/solid.csv and its
# tables into bench/README.md. Some minutes on two cores; RANKS=1 on one.
set -euo pipefail
cd "$(dirname "$0")/.."
source jobs/environment.sh
build=${1:-build/release} length=${2:-12}
run() { mpirun -n "${RANKS:-2}" "$build/bench/bench_solid" cases/plate/case.toml "$@"; }
{
  echo "what,orientation,speed,measured,second,wanted,third"
  for up in 500 1000 2000 3350; do
    for orientation in 1 2 3 4 5 6 7 8 100 110 111; do run shock $orientation 0.5 $up "$length"; done
  done
  for orientation in 100 110 111 1 2 3 4; do run tension $orientation 0.5; done
} | tee bench/results/solid.csv
/usr/bin/python3 bench/plot_solid.py
