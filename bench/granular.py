#!/usr/bin/python3
"""Writes the table of results/granular.csv, as run_granular.sh prints it, into README.md.

SPDX-License-Identifier: BSD-3-Clause
"""
import csv
import pathlib
import statistics

from readme import replace_section

here = pathlib.Path(__file__).resolve().parent
rows = list(csv.DictReader(open(here / "results/granular.csv")))


def median(program, key, data, model, ranks):
    values = [
        float(r[key])
        for r in rows
        if (r["program"], r["data"], r["model"], r["ranks"]) == (program, data, model, ranks)
    ]
    return statistics.median(values) if values else None


text = ["| packing | law | ranks | Spall | LAMMPS | ratio | bytes, Spall | LAMMPS | ratio |", "|---|---|--:|--:|--:|--:|--:|--:|--:|"]
for case in dict.fromkeys((r["data"], r["model"], r["ranks"]) for r in rows):
    speed, bytes_ = ([median(p, key, *case) for p in ("spall", "lammps")] for key in ("million_steps_processor_s", "bytes_a_body"))
    if None in speed:
        continue
    text.append(
        f"| {case[0]} | {case[1]} | {case[2]} | {speed[0]:.1f} | {speed[1]:.1f} | **{speed[0] / speed[1]:.2f}** "
        f"| {bytes_[0]:.0f} | {bytes_[1]:.0f} | {bytes_[0] / bytes_[1]:.2f} |"
    )
replace_section(here / "README.md", "granular", "\n".join(text))
