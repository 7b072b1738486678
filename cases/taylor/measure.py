"""Runs the cylinder at some resolutions and orientations, and puts its length and foot beside
finite elements with the same law, and beside what was measured.

    /usr/bin/python3 cases/taylor/measure.py [--material copper] [--speed 190] [--across 8 12]
    [--seeds 1 2 3] [--whole] [--grains 3] [--ranks 2]        prints a table

Length: by how much the lattice has become shorter, of the whole length. Foot: by how much the
largest distance from the axis has grown, of the whole width. Both of bodies that have not failed.
--grains: a polycrystal, its grains so many mm large, instead of one crystal.
--whole: nothing fails, by a copy of the material without the constants that say when.
SPDX-License-Identifier: BSD-3-Clause
"""
import argparse
import sys
import tempfile
from pathlib import Path

import h5py
import numpy as np

import finite_elements
from finite_elements import LENGTH, MATERIALS, RADIUS

HERE = Path(__file__).parent
sys.path.append(str(HERE.parent))
from program import PROGRAM, spall  # noqa: E402

MEASURED = {("copper", 190): (16.2, 13.5)}  # mm, length and foot: Johnson & Cook 1983
ELEMENTS = 20  # across


def shape(folder):
    with h5py.File(folder / "trajectory.h5") as file:
        x = file["particles/all/position/value"][:]
        holds = file["particles/all/damage/value"][-1] < 1
    first, last = x[0], x[-1]
    length = np.ptp(last[holds, 2]) / np.ptp(first[holds, 2]) * LENGTH
    widest = [np.hypot(at[holds, 0], at[holds, 1]).max() for at in (first, last)]
    foot = widest[1] / widest[0] * 2 * RADIUS
    return 1e3 * length, 1e3 * foot, len(first), np.count_nonzero(~holds)


def case_of(folder, options):
    text = (HERE / "case.toml").read_text()
    if options.grains:
        text = text.replace('orientation = "random"', f'grains = "{options.grains} mm"')
    material = MATERIALS / f"{options.material}.toml"
    if options.whole:
        lines = [line for line in material.read_text().splitlines() if not line.startswith(
                     ("spall_strength", "fracture_energy", "johnson_cook_d"))]
        material = folder / material.name
        material.write_text("\n".join(lines) + "\n")
    (folder / "case.toml").write_text(text.replace('library = "copper"', f'file = "{material}"'))
    return folder / "case.toml"


def run(options, across, seed):
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        spall("run", case_of(folder, options), "--out", folder / "out", ranks=options.ranks,
              program=options.spall,
              changes=[f"seed={seed}", "solid.courant=0.2", "phases.impact.step=0.5e-6",
                       f"groups.cylinder.packing.diameter={2 * RADIUS / across}",
                       f"groups.cylinder.velocity=[0, 0, {-options.speed}]"])
        return shape(folder / "out")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--material", default="copper")
    parser.add_argument("--speed", type=float, default=190, help="m/s")
    parser.add_argument("--across", type=int, nargs="+", default=[8, 12])
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3])
    parser.add_argument("--spall", default=PROGRAM)
    parser.add_argument("--ranks", type=int, default=2)
    parser.add_argument("--grains", type=float, help="mm, mean size")
    parser.add_argument("--whole", action="store_true", help="nothing fails")
    options = parser.parse_args()
    elements = finite_elements.run(finite_elements.Metal(options.material), options.speed, ELEMENTS)
    beside = {"elements": elements[:2]}
    if (options.material, options.speed) in MEASURED:
        beside["measured"] = MEASURED[options.material, options.speed]
    for name, (length, foot) in beside.items():
        print(f"{name}: length {length:.2f} mm, foot {foot:.2f} mm")
    print("| across | seed | bodies | failed | length, mm |" +
          "".join(f" {name} |" for name in beside) + " foot, mm |" +
          "".join(f" {name} |" for name in beside) + "\n|" + (5 + 1 + 2 * len(beside)) * "--:|")
    for across in options.across:
        for seed in options.seeds:
            *found, bodies, failed = run(options, across, seed)
            row = f"| {across} | {seed} | {bodies} | {failed} |"
            for k, value in enumerate(found):
                row += f" {value:.2f} |" + "".join(
                    f" {100 * (value / known[k] - 1):+.1f} % |"
                    for known in beside.values())
            print(row, flush=True)


if __name__ == "__main__":
    main()
