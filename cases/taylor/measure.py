#!/usr/bin/env python3
# Runs the cylinder at some resolutions and orientations, and puts its length and foot beside what
# was measured.
# SPDX-License-Identifier: BSD-3-Clause
"""usage: measure.py [--across 8 12] [--seeds 1 2 3] [--whole] [--grains 3] [--ranks 2]
[--spall build/release/spall]    prints a table.

Length: by how much the lattice has become shorter, of the whole length. Foot: by how much the
largest distance from the axis has grown, of bodies that have not failed, of the whole width.
--grains: a polycrystal, its grains so many mm large, instead of one crystal.
--whole: nothing fails, by a copy of the material without the constants that say when.
"""
import argparse
import subprocess
import tempfile
from pathlib import Path

import h5py
import numpy as np

HERE = Path(__file__).parent
LENGTH, RADIUS, STEP = 25.4e-3, 3.81e-3, 25e-9  # the step of 10 across
MEASURED = {"length": 16.2, "foot": 13.5}  # mm, Johnson & Cook 1983


def shape(folder):
    with h5py.File(folder / "trajectory.h5") as file:
        x = file["particles/all/position/value"][:]
        holds = file["particles/all/damage/value"][-1] < 1
    first, last = x[0], x[-1]
    extent = np.ptp(first[:, 2])
    length = np.ptp(last[:, 2]) / extent * LENGTH
    widest = [np.hypot(at[holds, 0], at[holds, 1]).max() for at in (first, last)]
    foot = widest[1] / widest[0] * 2 * RADIUS
    return 1e3 * length, 1e3 * foot, len(first), np.count_nonzero(~holds)


def case_of(folder, whole, grains):
    text = (HERE / "case.toml").read_text()
    if grains:
        text = text.replace('orientation = "random"', f'grains = "{grains} mm"')
    material = HERE.parent / "materials" / "copper.toml"
    if whole:
        lines = [line for line in material.read_text().splitlines() if "spall_strength" not in line
                 and "cook_d" not in line]
        material = folder / "copper.toml"
        material.write_text("\n".join(lines) + "\n")
    (folder / "case.toml").write_text(text.replace('library = "copper"', f'file = "{material}"'))
    return folder / "case.toml"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--across", type=int, nargs="+", default=[8, 12])
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3])
    parser.add_argument("--spall", default="build/release/spall")
    parser.add_argument("--ranks", type=int, default=2)
    parser.add_argument("--grains", type=float, help="mm, mean size")
    parser.add_argument("--whole", action="store_true", help="nothing fails")
    args = parser.parse_args()
    print(
        "| across | seed | bodies | failed | length, mm | error | foot, mm | error "
        "|\n|--:|--:|--:|--:|--:|--:|--:|--:|")
    for across in args.across:
        for seed in args.seeds:
            spacing = 2 * RADIUS / across
            with tempfile.TemporaryDirectory() as scratch:
                out = Path(scratch) / "out"
                case = case_of(Path(scratch), args.whole, args.grains)
                subprocess.run(["mpirun", "--oversubscribe", "-n", str(args.ranks), args.spall,
                                "run", str(case), "--out", str(out),
                                "--set", f"seed={seed}", "--set",
                                f"groups.cylinder.packing.diameter={spacing}",
                                "--set", f"phases.impact.step={STEP * 10 / across}"], check=True,
                               stdout=subprocess.DEVNULL)
                length, foot, bodies, failed = shape(out)
            error = [f"{100 * (value / MEASURED[name] - 1):+.1f} %"
                     for name, value in (("length", length), ("foot", foot))]
            print(
                f"| {across} | {seed} | {bodies} | {failed} | {length:.2f} | {error[0]} | "
                f"{foot:.2f} | {error[1]} |", flush=True)


if __name__ == "__main__":
    main()
