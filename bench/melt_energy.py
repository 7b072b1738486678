#!/usr/bin/python3
"""Writes how the energy of a melt drifts, by Spall and by LAMMPS, into section melt_energy of
README.md.

SPDX-License-Identifier: BSD-3-Clause
usage: melt_energy.py SERIES PLAIN SHIFTED CHECKED: Spall's series.csv, and LAMMPS's logs of step
and energy a body
"""
import csv
import pathlib
import sys

import numpy as np

from lammps_files import read_log
from readme import origin, replace_section

bodies = 32000
melted = 500  # steps in which the lattice melts: its energy is not yet that of the liquid's steps


def of_spall(path):
    rows = list(csv.DictReader(open(path)))
    return np.array([[float(row["step"]), (float(row["kinetic"]) + float(row["bonds"])) / bodies]
                     for row in rows])


def row(name, values):
    """The straight line through the melted part: its change over all of it, and the rest's
    deviation from it."""
    step, energy = values[values[:, 0] >= melted].T
    slope, offset = np.polyfit(step, energy, 1)
    rest = energy - (slope * step + offset)
    # Of the slope, if the deviations are independent.
    error = rest.std() / (step.std() * np.sqrt(len(step)))
    span = step[-1] - step[0]
    return f"| {name} | {slope * span:.1e} | {error * span:.0e} | {rest.std():.1e} |"


text = [
    origin(1) + "; 32,000 bodies, J a body with depth 1 J",
    "",
    "| program | drift after melting | its standard error | scatter about it |",
    "|---|--:|--:|--:|",
    row("Spall", of_spall(sys.argv[1])),
    row("LAMMPS, `in.lj` as it is", read_log(sys.argv[2])),
    row("LAMMPS, `pair_modify shift yes`", read_log(sys.argv[3])),
    row("LAMMPS, the same with `neigh_modify every 1 check yes`", read_log(sys.argv[4])),
]
replace_section(pathlib.Path(__file__).resolve().parent / "README.md", "melt_energy",
                "\n".join(text))
print("\n".join(text))
