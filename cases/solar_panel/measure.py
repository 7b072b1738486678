"""What the particle did to the panel, and what equations for two sheets say of it.

    /usr/bin/python3 cases/solar_panel/measure.py out/solar_panel

Writes cells.png beside this file, and prints the table of README.md.
SPDX-License-Identifier: BSD-3-Clause
"""
import math
import sys
import tomllib
from pathlib import Path

import h5py
import matplotlib
import numpy as np

HERE = Path(__file__).parent
sys.path += [str(HERE.parent / "shields"), str(HERE.parent / "plate"),
             str(HERE.parent.parent / "bench")]
from equations import Shot, jsc, reimerdes  # noqa: E402
from shots import holes  # noqa: E402

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

FRONT, CELLS, PARTICLE = 1, 2, 3  # groups, as case.toml has them
RADIUS, SPACING = 4e-3, 0.1e-3  # m, of cells and front sheet, and of their bodies
EDGE = 0.8e-3  # m: so much at the rim of the cut-out is not looked at
SHEET, GAP, SPEED, BALL = 0.025, 2.0, 7.0, 0.5  # cm, cm, km/s, mm
GLASS = 0.03 * 2.201 / 2.703  # cm of aluminium that weigh as much as the cells
YIELD = 40.0  # ksi, of 6061-T6


def critical(equation, bumper):
    """mm: the ball that two sheets just bear."""
    return 10 * equation(Shot(0, "", "", ("AA6061-T6",) * 3, (2.703,) * 3, BALL / 10, 0, SPEED,
                              bumper, GAP, SHEET, YIELD, False))


def area_without(place, there):
    """mm^2 of a sheet where no body is, of those that are `there`: by pixels of two spacings."""
    edges = np.arange(-RADIUS, RADIUS + SPACING, 2 * SPACING)
    counts, _, _ = np.histogram2d(place[there, 0], place[there, 1], bins=[edges, edges])
    middles = (edges[:-1] + edges[1:]) / 2
    inside = np.add.outer(middles**2, middles**2) < (RADIUS - EDGE)**2
    return 1e6 * (2 * SPACING)**2 * np.count_nonzero(inside & (counts == 0))


def main():
    folder = Path(sys.argv[1])
    results = tomllib.loads((folder / "results.toml").read_text())
    with h5py.File(folder / "trajectory.h5") as file:
        bodies = file["particles/all"]
        group = bodies["group"][:]
        place, velocity = (bodies[f"{name}/value"][-1] for name in ("position", "velocity"))
        damage, mass = bodies["damage/value"][-1], bodies["mass"][:]
        first = bodies["velocity/value"][0][:, 2]
    cells, front, particle = (group == k for k in (CELLS, FRONT, PARTICLE))
    near = cells & (np.abs(place[:, 2]) < 1e-3)
    thrown = (cells | particle) & (velocity[:, 2] > 0)
    back = np.sum((mass * velocity[:, 2])[thrown]) / -np.sum((mass * first)[particle])
    wall = results["shield_rear"]
    print("| | |\n|---|--:|")
    for name, there in (("front sheet in which nothing whole is left", front & (damage < 1)),
                        ("cells in which no glass is left", near),
                        ("cells in which none is left that has not failed", near & (damage < 1))):
        area = area_without(place, there)
        print(f"| {name}, mm² | {area:.1f} |")
        print(f"| a circle as large, mm | {math.sqrt(4 * area / math.pi):.1f} |")
    least, most = (BALL * hole for hole in holes(1e3 * SPEED, 10 * SHEET / BALL))
    print(f"| hole in such a sheet without cells by formulas, mm | {least:.2f}–{most:.2f} |")
    print(f"| momentum thrown back, of the particle's | {back:.2f} |")
    print(f"| rear sheet | {wall['verdict']}, margin {wall['margin']:.2f} |")
    for name, equation in (("JSC", jsc), ("Reimerdes", reimerdes)):
        print(f"| just borne by two sheets after {name}, mm | {critical(equation, SHEET):.2f} |")
        print(f"| the same with the cells' mass in the front one, mm "
              f"| {critical(equation, SHEET + GLASS):.2f} |")
    print(f"| energy that no entry explains | "
          f"{100 * results['conservation']['energy_unexplained']:.2f} % |")
    figure, axes = plt.subplots(figsize=(5, 4.4), layout="constrained")
    drawn = axes.scatter(1e3 * place[near, 0], 1e3 * place[near, 1], c=damage[near], s=5,
                         cmap="magma_r", vmin=0, vmax=1)
    figure.colorbar(drawn, label="damage: 1 bears no tension")
    axes.set(aspect="equal", xlabel="x (mm)", ylabel="y (mm)", xlim=(-4.2, 4.2), ylim=(-4.2, 4.2))
    figure.savefig(HERE / "cells.png", dpi=110)


if __name__ == "__main__":
    main()
