#!/usr/bin/python3
"""Draws the collapse of the column and writes the runouts of runs into README.md.

SPDX-License-Identifier: BSD-3-Clause
usage: cases/column/picture.py ROLLING_FRICTION=FOLDER …; the first is drawn
"""
import pathlib
import sys

import numpy as np

here = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(here.parent), str(here.parent.parent / "bench")]
from grains import draw, read  # noqa: E402
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


def main(runs):
    rows = [
        "| rolling friction | runout (r - r0)/r0 | against 1.24 a, sand (Lube et al. 2004) | "
        "height, mm |", "|--:|--:|--:|--:|"]
    for k, (friction, folder) in enumerate(runs):
        all_x, times, grain = read(folder)
        if k == 0:
            frames = [0, len(times) // 4, len(times) // 2, len(times) - 1]
            draw(here / "collapse.png", all_x, times, grain, frames, height=7, top=36)
        runout = extent(all_x[-1], grain) / RADIUS - 1
        # The highest grains that are not alone.
        height = np.quantile(all_x[-1][:, 2], 0.999) + grain
        rows.append(
            f"| {friction} | {runout:.2f} | {100 * (runout / 1.24 - 1):+.0f} % | "
            f"{1e3 * height:.0f} |")
    replace_section(here / "README.md", "runout", "\n".join(rows))


main([argument.split("=") for argument in sys.argv[1:]])
