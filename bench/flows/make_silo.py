#!/usr/bin/python3
"""Writes a LAMMPS data file of a silo that is filled: 3,000 grains of 1 m and 1 kg/m^3 will fall in
a cylinder of radius
5 m (type 1) on a layer of 69 at z = 0 (type 2), which is lowered later.

SPDX-License-Identifier: BSD-3-Clause
usage: make_silo.py SEED DATA
"""
import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
from lammps_files import write_spheres  # noqa: E402

random = np.random.default_rng(int(sys.argv[1]))


def layer(spacing, within):
    """Places of a square lattice around the axis."""
    steps = spacing * np.arange(-5, 6)
    x, y = np.meshgrid(steps, steps)
    plane = np.stack([x.ravel(), y.ravel()], 1)
    return plane[np.hypot(*plane.T) < within]


base = layer(1.0, 4.48)
base = np.column_stack([base, np.zeros(len(base))])
plane = layer(1.2, 4.35)
rows = np.arange(3000)
fall = np.column_stack([plane[rows % len(plane)], 1.3 + 1.2 * (rows // len(plane))])
fall += random.uniform(-0.09, 0.09, fall.shape)
place, kind = np.vstack([fall, base]), np.repeat([1, 2], [len(fall), len(base)])
velocity = random.uniform(-0.5, 0.5, place.shape) * (kind == 1)[:, None]
write_spheres(sys.argv[2], "silo", (-6, -6, -5), (6, 6, fall[:, 2].max() + 5), 1, 1, place,
              velocity, kind)
