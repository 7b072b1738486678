"""Puts bench/results/scaling.csv as a table into bench/README.md: write_scaling.py CSV

SPDX-License-Identifier: BSD-3-Clause
"""
import csv
import pathlib
import statistics
import sys

from readme import replace_section


def main(path):
    with open(path) as file:
        about = file.readline().lstrip("# ").strip()
        rows = list(csv.DictReader(file))
    runs = {}  # medians over the rounds
    for row in rows:
        runs.setdefault((row["scene"], row["bodies"], int(row["ranks"])), []).append(row)
    lines = [about, "",
             "| scene | bodies | contacts | ranks | s | of a | ns a contact | speed-up | error "
             "| MB, all ranks |", "|---|--:|--:|--:|--:|---|--:|--:|---|--:|"]
    for (scene, bodies, ranks), same in runs.items():
        seconds = statistics.median(float(row["seconds"]) for row in same)
        alone = runs.get((scene, bodies, 1))
        speedup = (statistics.median(float(row["seconds"]) for row in alone) / seconds
                   if alone and ranks > 1 else None)
        row = same[-1]
        contacts = int(row["contacts"])
        per_contact = f"{1e9 * seconds / contacts:.1f}" if row["unit"] == "product" else ""
        lines.append(f"| {scene} | {int(bodies):,} | {f'{contacts:,}' if contacts else ''} | "
                     f"{ranks} | {seconds:.3g} "
                     f"| {row['unit']} | {per_contact} | {f'{speedup:.2f}' if speedup else ''} "
                     f"| {row['error']} | {row['peak_MB']} |")
    replace_section(pathlib.Path(__file__).resolve().parent / "README.md", "scaling",
                    "\n".join(lines))


if __name__ == "__main__":
    main(sys.argv[1])
