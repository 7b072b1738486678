#!/usr/bin/python3
"""Writes a LAMMPS data file of grains of 1 m and 1 kg/m^3 that will fall together: a silo, or a slope.

SPDX-License-Identifier: BSD-3-Clause
usage: make_flow.py silo|slope SEED DATA
silo: 3000 grains above z = 0 in a cylinder of radius 5 m. slope: 900 grains of type 1 over a rough layer of 100 of
type 2, in a box of 10 m by 10 m that repeats itself.
"""
import sys

import numpy as np

scene, seed, path = sys.argv[1], int(sys.argv[2]), sys.argv[3]
random = np.random.default_rng(seed)


def layers(spacing, half, inside, count, bottom, stir):
    """The first `count` places of a lattice along x, y, z that are inside, each stirred by up to `stir`."""
    steps = np.arange(-half + spacing / 2, half, spacing)
    y, x = np.meshgrid(steps, steps)
    plane = np.stack([x.ravel(), y.ravel()], 1)
    plane = plane[inside(plane)]
    rows = np.arange(count)
    places = np.column_stack([plane[rows % len(plane)], bottom + spacing * (rows // len(plane))])
    return places + random.uniform(-stir, stir, places.shape)


if scene == "silo":
    place = layers(1.2, 5, lambda p: np.hypot(*p.T) < 4.35, 3000, 0.7, 0.09)
    kind = np.ones(len(place), int)
    half = 6
else:
    ground = layers(1, 5, lambda p: p[:, 0] < 5, 100, 0, 0)
    ground[:, 2] += random.uniform(-0.3, 0.3, 100)
    flow = layers(10 / 9, 5, lambda p: p[:, 0] < 5, 900, 1.4, 0.05)
    place = np.vstack([flow, ground])
    kind = np.repeat([1, 2], [len(flow), len(ground)])
    half = 5
velocity = random.uniform(-0.5, 0.5, place.shape) * (kind == 1)[:, None]
with open(path, "w") as file:
    file.write(f"{scene}\n\n{len(place)} atoms\n{kind.max()} atom types\n\n")
    for axis, low, high in [("x", -half, half), ("y", -half, half), ("z", -2, place[:, 2].max() + 5)]:
        file.write(f"{low} {high:.17g} {axis}lo {axis}hi\n")
    file.write("\nAtoms\n\n")
    for k, x in enumerate(place):
        file.write(f"{k + 1} {kind[k]} 1 1 " + " ".join(f"{c:.17g}" for c in x) + "\n")
    file.write("\nVelocities\n\n")
    for k, v in enumerate(velocity):
        file.write(f"{k + 1} " + " ".join(f"{c:.17g}" for c in v) + " 0 0 0\n")
