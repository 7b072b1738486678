#!/usr/bin/python3
"""Measures the slope of the heaps that runs left, draws the first, writes README.md's table.

SPDX-License-Identifier: BSD-3-Clause
usage: cases/repose/picture.py "LABEL"=FOLDER[,FOLDER …] …; folders of one label differ by seed
"""
import pathlib
import sys

import numpy as np

here = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(here.parent), str(here.parent.parent / "bench")]
from grains import draw, read  # noqa: E402
from readme import replace_section  # noqa: E402

TABLE = 0.048  # m, its radius


def surface(x, grain):
    """Radii of rings and the mean height of their highest grains, in cells three grain radii
    wide."""
    x = x[x[:, 2] > 0]
    rho, angle = np.hypot(x[:, 0], x[:, 1]), np.arctan2(x[:, 1], x[:, 0]) / (2 * np.pi) + 0.5
    width = 3 * grain
    radii, heights = [], []
    for ring in range(int(TABLE / width)):
        middle = (ring + 0.5) * width
        cells = max(1, int(2 * np.pi * middle / width))
        top = np.zeros(cells)
        inside = (rho >= ring * width) & (rho < (ring + 1) * width)
        np.maximum.at(top, (angle[inside] * cells).astype(int) % cells, x[inside, 2])
        radii.append(middle)
        heights.append(top.mean())
    return np.array(radii), np.array(heights)


def slope(x, grain):
    """Degrees, of a line through the surface between the blunt tip and the rim."""
    radii, heights = surface(x, grain)
    flank = (radii > 0.2 * TABLE) & (radii < 0.9 * TABLE)
    return -np.degrees(np.arctan(np.polyfit(radii[flank], heights[flank], 1)[0]))


def main(runs):
    rows = ["| grains | angle of repose | grains left |", "|---|--:|--:|"]
    for k, (label, folders) in enumerate(runs):
        angles, left = [], []
        for folder in folders.split(","):
            all_x, times, grain = read(folder)
            if k == 0 and not angles:
                draw(here / "heap.png", all_x, times, grain, [0, 3, len(times) - 1], height=6)
            angles.append(slope(all_x[-1], grain))
            left.append(int((all_x[-1][:, 2] > 0).sum()))
        spread = f" ({min(angles):.1f}–{max(angles):.1f}, {len(angles)} seeds)" if len(
            angles) > 1 else ""
        rows.append(f"| {label} | {np.mean(angles):.1f}°{spread} | {np.mean(left):.0f} |")
    replace_section(here / "README.md", "angles", "\n".join(rows))


main([argument.rsplit("=", 1) for argument in sys.argv[1:]])
