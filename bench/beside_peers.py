#!/usr/bin/python3
"""Writes the medians of results/NAME.csv, as run_NAME.sh leaves it, into section NAME of README.md
and prints them.

SPDX-License-Identifier: BSD-3-Clause
usage: beside_peers.py granular|lennard_jones|untuned
"""
import collections
import csv
import pathlib
import statistics
import sys

from readme import origin, replace_section

here = pathlib.Path(__file__).resolve().parent
name = sys.argv[1]
values = collections.defaultdict(lambda: collections.defaultdict(list))
for row in csv.DictReader(open(here / "results" / f"{name}.csv")):
    key = (row["scene"], row["ranks"]), row["program"]
    values[key][0].append(float(row["million_steps_s"]))
    values[key][1].append(float(row["million_steps_processor_s"]))
    values[key][2].append(float(row["bytes_a_body"]))
median = {key: [statistics.median(v[k]) for k in range(3)] for key, v in values.items()}

text = [
    origin(2)
    + "; wall time and, in brackets, processor time; medians, of its ratio least–most of the turns",
    "",
    "| scene | ranks | Spall, million steps/s | other | its million steps/s | ratio | bytes a "
    "body, Spall | other | ratio |",
    "|---|--:|--:|---|--:|--:|--:|--:|--:|",
]
for (scene, ranks), program in median:
    if program == "spall":
        continue
    ours, other = median[(scene, ranks), "spall"], median[(scene, ranks), program]
    turns = [a / b
             for a, b in zip(values[(scene, ranks), "spall"][1],
                             values[(scene, ranks), program][1])]
    text.append(
        f"| {scene} | {ranks} | {ours[0]:.1f} ({ours[1]:.1f}) | {program} | {other[0]:.1f} "
        f"({other[1]:.1f}) "
        f"| **{ours[0] / other[0]:.2f}** ({ours[1] / other[1]:.2f}, "
        f"{min(turns):.2f}–{max(turns):.2f}) | {ours[2]:.0f} | {other[2]:.0f} | "
        f"{ours[2] / other[2]:.2f} |"
    )
text.append("")
for (scene, ranks), program in median:
    if program == "spall" and ranks == "2" and ((scene, "1"), "spall") in median:
        gain = median[(scene, "2"), "spall"][0] / median[(scene, "1"), "spall"][0]
        text.append(f"A second rank, {scene}: {gain:.2f} times the speed.  ")
replace_section(here / "README.md", name, "\n".join(text))
print("\n".join(text))
