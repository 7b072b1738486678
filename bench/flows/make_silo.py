#!/usr/bin/python3
"""Writes a LAMMPS data file of a silo that is filled: 3,000 grains of 1 m and 1 kg/m^3 will fall in a cylinder of radius
5 m (type 1) on a layer of 69 at z = 0 (type 2), which is lowered later.

SPDX-License-Identifier: BSD-3-Clause
usage: make_silo.py SEED DATA
"""
import sys

import numpy as np

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
with open(sys.argv[2], "w") as file:
    file.write(f"silo\n\n{len(place)} atoms\n2 atom types\n\n-6 6 xlo xhi\n-6 6 ylo yhi\n-5 {fall[:, 2].max() + 5:.17g} zlo zhi\n")
    file.write("\nAtoms\n\n")
    for k, x in enumerate(place):
        file.write(f"{k + 1} {kind[k]} 1 1 " + " ".join(f"{c:.17g}" for c in x) + "\n")
    file.write("\nVelocities\n\n")
    for k, v in enumerate(velocity):
        file.write(f"{k + 1} " + " ".join(f"{c:.17g}" for c in v) + " 0 0 0\n")
