"""Puts bench/results/partition.csv as a table into bench/README.md: write_partition.py CSV

SPDX-License-Identifier: BSD-3-Clause
"""
import csv
import pathlib
import sys

from readme import replace_section


def main(path):
    with open(path) as file:
        about = file.readline().lstrip("# ").strip()
        rows = list(csv.DictReader(file))
    runs = {}
    for row in rows:
        runs.setdefault((row["shape"], row["bodies"], row["ranks"]), {})[row["cut"]] = row
    lines = [about, "",
             "| shape | bodies | ranks | ghosts by bisection, mean (most) | by METIS | imbalance | "
             "by METIS |",
             "|---|--:|--:|--:|--:|--:|--:|"]
    for (shape, bodies, ranks), cuts in runs.items():
        ghosts = [f"{cuts[cut]['ghosts_mean']} ({cuts[cut]['ghosts_most']})"
                  for cut in ("bisection", "metis")]
        uneven = [cuts[cut]["imbalance"] for cut in ("bisection", "metis")]
        lines.append(
            f"| {shape} | {int(bodies):,} | {ranks} | {ghosts[0]} | {ghosts[1]} | {uneven[0]} | "
            f"{uneven[1]} |")
    replace_section(pathlib.Path(__file__).resolve().parent / "README.md", "partition",
                    "\n".join(lines))


if __name__ == "__main__":
    main(sys.argv[1])
