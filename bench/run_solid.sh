#!/usr/bin/env bash
# Aluminium by its material's law against what is known of it (bench_solid); writes bench/results/solid.csv and its
# tables into bench/README.md. Some ten minutes on two cores; RANKS=1 on one. PARTS="spall": only these;
# SPALL="6 8 12": spacings of the flyers.
set -euo pipefail
cd "$(dirname "$0")/.."
source jobs/environment.sh
build=${1:-build/release} length=${2:-18}
parts=${PARTS:-shock tension spall}
run() { mpirun -n "${RANKS:-2}" "$build/bench/bench_solid" cases/plate/case.toml "$@"; }
rows=$(mktemp)
echo "what,orientation,speed,measured,second,wanted,third,plane,stretch" > "$rows"
for part in shock tension spall; do
  if [[ " $parts " != *" $part "* ]]; then
    grep "^$part," bench/results/solid.csv >> "$rows" || true
    continue
  fi
  case $part in
    shock)
      for up in 500 1000 2000 3350; do
        for orientation in 1 2 3 4 5 6 7 8 100 110 111; do run shock $orientation 0.3 $up "$length"; done
      done ;;
    tension) for orientation in 100 110 111 1 2 3 4; do run tension $orientation 0.3; done ;;
    spall)
      for flyer in ${SPALL:-6 8}; do
        for orientation in 100 110 111 1 2 3 4; do run spall $orientation 0.3 500 "$flyer"; done
      done ;;
  esac | tee -a "$rows"
done
mv "$rows" bench/results/solid.csv
/usr/bin/python3 bench/plot_solid.py
