#!/usr/bin/python3
"""The slopes at which runs of a tilting tray slide and flow; writes README.md's table.

SPDX-License-Identifier: BSD-3-Clause
usage: cases/tilt/angles.py "LABEL"=FOLDER[,FOLDER …] …; folders of one label differ by seed
"""
import pathlib
import sys

import h5py
import numpy as np

here = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(here.parent.parent / "bench"))
from readme import replace_section  # noqa: E402

FLOOR, BOULDERS = 0, 3  # groups
CELL = 1.5       # m, of the tray's plane, of which the highest boulder counts
SETTLED = 8.0    # degrees: until then the boulders fall and come to rest
SLID = 0.5       # m
FLOW = 6.0       # degrees
MIDDLE = 8.0     # m from the middle of the tray: its ends are left out


def read(folder):
    """Tilts of the tray (degrees) and places (m) of the boulders along the tray, across and above
    it, at all times."""
    with h5py.File(pathlib.Path(folder) / "trajectory.h5") as file:
        bodies = file["particles/all"]
        group = bodies["group"][:]
        all_x = bodies["position/value"][:]
    floor = all_x[:, group == FLOOR]
    row = np.flatnonzero(np.isclose(floor[0, :, 1], floor[0, 0, 1]))
    along = (floor[:, row[np.argmax(floor[0, row, 0])]] -
             floor[:, row[np.argmin(floor[0, row, 0])]])
    tilt = np.arctan2(-along[:, 2], along[:, 0])
    x, y, z = np.moveaxis(all_x[:, group == BOULDERS], 2, 0)
    cos, sin = np.cos(tilt)[:, None], np.sin(tilt)[:, None]
    return np.degrees(tilt), np.stack([x * cos - z * sin, y, x * sin + z * cos], axis=2)


def slope(places):
    """Degrees against the tray, positive where the surface is steeper: of a line through the
    highest boulders of cells."""
    along, across, above = places.T
    inside = np.abs(along) < MIDDLE
    column = np.floor(along[inside] / CELL).astype(int)
    row = np.floor(across[inside] / CELL).astype(int)
    top = {}
    for cell, at in zip(zip(column, row), above[inside]):
        top[cell] = max(top.get(cell, 0), at)
    middles = [(cell[0] + 0.5) * CELL for cell in top]
    return -np.degrees(np.arctan(np.polyfit(middles, list(top.values()), 1)[0]))


def angles(folder):
    """Degrees: the slope at which the boulders have slid by half of their diameter in the mean, and
    the mean slope while the tray tilts on by FLOW."""
    tilts, places = read(folder)
    settled = int(np.argmax(tilts >= SETTLED))
    slid = (places[:, :, 0] - places[settled, :, 0]).mean(axis=1)
    begin = int(np.argmax(slid > SLID))
    end = int(np.argmax(tilts >= tilts[begin] + FLOW))
    if begin <= settled or end == 0:
        sys.exit(f"{folder}: tilted to {tilts[-1]:.0f} degrees, which is not enough")
    slopes = [tilts[k] + slope(places[k]) for k in range(begin, end + 1)]
    return slopes[0], np.mean(slopes)


def told(values):
    if len(values) == 1:
        return f"{values[0]:.1f}°"
    return f"{np.mean(values):.1f}° ({min(values):.1f}–{max(values):.1f})"


def main(runs):
    rows = ["| boulders | slide at | flow at |", "|---|--:|--:|"]
    for label, folders in runs:
        slide, flow = zip(*(angles(folder) for folder in folders.split(",")))
        rows.append(f"| {label} | {told(slide)} | {told(flow)} |")
    print("\n".join(rows))
    replace_section(here / "README.md", "angles", "\n".join(rows))


main([argument.rsplit("=", 1) for argument in sys.argv[1:]])
