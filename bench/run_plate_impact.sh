#!/usr/bin/env bash
# Plates of copper, steel and aluminium that meet, against the impedance match of their Hugoniots; writes
# bench/results/plate_impact.csv, whose first line names the commit. Some minutes; RANKS=1 on one core; SEEDS: orientations.
set -euo pipefail
cd "$(dirname "$0")/.."
source jobs/environment.sh
build=${1:-build/release} length=${2:-10}
rows=$(mktemp)
{
  echo "# commit $(bench/commit.sh)"
  echo "flyer,target,speed,seed,length,velocity,velocity_by_hand,pressure,pressure_by_hand"
  for pair in "copper steel_304" "steel_304 aluminium_6061_t6" "copper aluminium_6061_t6"; do
    for speed in 1000 2000; do
      for seed in ${SEEDS:-1 2 3}; do
        mpirun -n "${RANKS:-2}" "$build/bench/bench_plate_impact" cases/materials $pair $speed $seed "$length"
      done
    done
  done
} | tee "$rows"
mv "$rows" bench/results/plate_impact.csv
chmod 644 bench/results/plate_impact.csv
/usr/bin/python3 - <<'PYTHON'
import csv
import itertools
import re

with open("bench/results/plate_impact.csv") as file:
    commit = file.readline().split()[-1]
    rows = list(csv.DictReader(file))
lines = ["| flyer on target | m/s | interface by hand, m/s | Spall | error | pressure by hand, GPa | Spall | error |",
         "|---|--:|--:|--:|--:|--:|--:|--:|"]
for (flyer, target, speed), group in itertools.groupby(rows, lambda r: (r["flyer"], r["target"], r["speed"])):
    group = list(group)
    cells = [f"{flyer} on {target}", speed]
    for what, unit, digits in (("velocity", 1, 0), ("pressure", 1e9, 2)):
        hand = float(group[0][what + "_by_hand"]) / unit
        values = [float(row[what]) / unit for row in group]
        mean = sum(values) / len(values)
        cells += [f"{hand:.{digits}f}", f"{mean:.{digits}f} ({min(values):.{digits}f}–{max(values):.{digits}f})",
                  f"{100 * (mean / hand - 1):+.1f} %"]
    lines.append("| " + " | ".join(cells) + " |")
lines.append(f"\nMean (least–most) over {len(group)} orientations, plates of {rows[0]['length']} spacings; commit {commit}.")
path = "bench/README.md"
with open(path) as file:
    text = file.read()
text = re.sub("<!-- plate_impact -->.*<!-- end of plate_impact -->",
              lambda _: "<!-- plate_impact -->\n" + "\n".join(lines) + "\n<!-- end of plate_impact -->", text, flags=re.S)
with open(path, "w") as file:
    file.write(text)
PYTHON
