#!/usr/bin/python3
"""Draws the collapse of the column and writes its runout into README.md.

SPDX-License-Identifier: BSD-3-Clause
usage: cases/column/picture.py out/column
"""
import pathlib
import sys

import h5py
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

here = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(here.parent.parent / "bench"))
from readme import replace_section  # noqa: E402

RADIUS = 0.03  # m, of the column: its height over it is a = 1


def coverage(x, grain, edges):
    """Area of the grains over that of the rings in which they lie."""
    r = np.hypot(x[:, 0], x[:, 1])
    count, _ = np.histogram(r, edges)
    return count * np.pi * grain**2 / (np.pi * (edges[1:] ** 2 - edges[:-1] ** 2))


def extent(x, grain):
    """Radius up to which grains cover at least half of the ground."""
    edges = np.arange(0, 0.3, 2 * grain)
    covered = coverage(x, grain, edges) > 0.5
    return edges[np.argmin(covered)] if not covered.all() else edges[-1]


def main(folder):
    with h5py.File(folder / "trajectory.h5") as file:
        all_x = file["particles/all/position/value"][:]
        times = file["particles/all/position/time"][:]
        grain = float(np.ravel(file["particles/all/radius"])[0])
    figure, axes = plt.subplots(4, 1, figsize=(8, 7), sharex=True, sharey=True)
    shown = [0, len(times) // 4, len(times) // 2, len(times) - 1]
    for axis, k in zip(axes, shown):
        x = 1e3 * all_x[k]
        slab = np.abs(x[:, 1]) < 6e3 * grain
        order = np.argsort(-x[slab, 1])
        near = x[slab][order]
        axis.scatter(near[:, 0], near[:, 2], s=9, c=near[:, 1], cmap="copper", linewidths=0)
        axis.set_aspect("equal")
        axis.set_title(f"{1e3 * times[k]:.0f} ms", loc="right", fontsize=9, y=0.7)
        axis.set_ylim(0, 36)
    axes[-1].set_xlabel("mm")
    figure.tight_layout()
    figure.savefig(here / "collapse.png", dpi=90)

    start = RADIUS
    end = extent(all_x[-1], grain)
    runout, lube = (end - start) / start, 1.24
    replace_section(
        here / "README.md",
        "runout",
        f"{len(all_x[-1])} grains; runout (r - r0)/r0 = **{runout:.2f}**, measured on sand 1.24 a = "
        f"{lube:.2f} (Lube et al. 2004): {100 * (runout / lube - 1):+.0f} %; height of the deposit "
        f"{1e3 * (all_x[-1][:, 2].max() + grain):.0f} mm.",
    )


main(pathlib.Path(sys.argv[1]))
