#!/usr/bin/python3
"""Writes a LAMMPS data file of spheres with radii of 0.1 to 1 m, so many a radius as r^-3, at
random and in motion.

SPDX-License-Identifier: BSD-3-Clause
usage: make_bed.py COUNT DATA: a periodic box filled to 0.3, velocities of 1 m/s in each component,
2500 kg/m^3
"""
import math
import pathlib
import sys

import numpy as np
from scipy.spatial import cKDTree

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
from lammps_files import write_spheres  # noqa: E402

count, path = int(sys.argv[1]), sys.argv[2]
random = np.random.default_rng(1)
share = random.random(count)
radius = np.sort((1 + share * (0.1**-2 - 1)) ** -0.5)[::-1]  # of r^-3 between 0.1 and 1
edge = (4 / 3 * math.pi * (radius**3).sum() / 0.3) ** (1 / 3)
place = np.empty((0, 3))
begin = 0
while begin < count:
    # Spheres of nearly one size together, as often as some of them find no place.
    end = min(np.searchsorted(-radius, -radius[begin] / 1.1), begin + 2000)
    largest = radius[begin]
    waiting = end - begin
    sizes = np.ceil(np.log(radius[:begin] / radius[begin])
                    / np.log(1.3)).astype(int) if begin else np.empty(0, int)
    trees = [(cKDTree(place[sizes == s], boxsize=edge), radius[:begin][sizes == s].max())
             for s in np.unique(sizes)]
    new = np.empty((0, 3))
    while len(new) < waiting:
        tries = random.random((4 * waiting, 3)) * edge
        clear = np.ones(len(tries), bool)
        for tree, size in trees:
            clear[clear] = tree.query(tries[clear],
                                      distance_upper_bound=largest + size)[0] == np.inf
        tries = np.vstack([new, tries[clear]])
        taken = np.ones(len(tries), bool)
        for a, b in sorted(cKDTree(tries, boxsize=edge).query_pairs(2 * largest)):
            taken[b] &= not taken[a]
        new = tries[taken][:waiting]
    place = np.vstack([place, new])
    begin = end
velocity = random.normal(size=(count, 3))
write_spheres(path, "spheres of 0.1 to 1 m", 3 * [0], 3 * [edge], 2 * radius, 2500, place, velocity)
