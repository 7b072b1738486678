#!/usr/bin/python3
"""Writes bodies of a LAMMPS data file as the files that `packing.kind = "file"` reads, one for each
type.

SPDX-License-Identifier: BSD-3-Clause
usage: data_to_restart.py DATA STEM: writes STEM_1.h5, STEM_2.h5, ... and prints where their centres
are, a line for each `--set` of `spall run`. Atoms are those of atom_style sphere (id type diameter
density x y z), or of atomic (id type x y z), which get a mass of 1 kg and a diameter of 1 m. Bodies
of one type share the group STEM_TYPE.
"""
import math
import sys

import h5py
import numpy as np


def section(lines, name, count):
    """The numbers of a section, by ascending ids."""
    first = next((k for k, line in enumerate(lines) if line.startswith(name)), None)
    if first is None:
        return None
    rows = np.array(
        [[float(word) for word in line.split()[:8]] for line in lines[first + 2:first + 2 + count]])
    return rows[np.argsort(rows[:, 0])]


path, stem = sys.argv[1:]
lines = open(path).read().split("\n")
count = int(next(line.split()[0] for line in lines if line.endswith("atoms")))
low, size = np.zeros(3), np.zeros(3)
for line in lines[:40]:
    for k, axis in enumerate("xyz"):
        if line.endswith(f"{axis}lo {axis}hi"):
            low[k], size[k] = float(line.split()[0]), float(line.split()[1]) - float(
                line.split()[0])
atoms, motion = section(lines, "Atoms", count), section(lines, "Velocities", count)
sphere = motion is not None and motion.shape[1] == 7
place = atoms[:, 4:7] if sphere else atoms[:, 2:5]
radius = atoms[:, 2] / 2 if sphere else np.full(count, 0.5)
mass = atoms[:, 3] * 4 / 3 * math.pi * radius**3 if sphere else np.ones(count)
place = low + np.where(size > 0, np.mod(place - low, np.where(size > 0, size, 1)),
                       place - low) if not sphere else place
settings = []
for kind in np.unique(atoms[:, 1]).astype(int):
    of = atoms[:, 1] == kind
    with h5py.File(f"{stem}_{kind}.h5", "w") as file:
        bodies = file.create_group("bodies")
        bodies["id"] = np.arange(of.sum(), dtype=np.int64)
        bodies["position"], bodies["velocity"] = place[of], motion[of, 1:4]
        bodies["radius"], bodies["mass"] = radius[of], mass[of]
        if sphere:
            bodies["angular_velocity"] = motion[of, 4:7]
    # Fixed bodies have no mass: their centre is that of equal densities, which is the same here.
    centre = (mass[of, None] * place[of]).sum(0) / mass[of].sum()
    settings.append(
        f"groups.{stem}_{kind}.volume.center=[{', '.join(f'{c:.17g}' for c in centre)}]")
print("\n".join(settings))
