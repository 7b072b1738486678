"""What LAMMPS reads and writes: data files of spheres, logs.

SPDX-License-Identifier: BSD-3-Clause
"""
import numpy as np


def write_spheres(path, title, low, high, diameter, density, place, velocity, kind=None):
    """A data file of atom_style sphere; LIGGGHTS reads it, too. Corners of the box and, a row a
    sphere, places, velocities and kinds from 1 on; diameters and densities are a row's or all
    rows'. SI."""
    count = len(place)
    kind = np.ones(count, int) if kind is None else kind
    diameter, density = np.broadcast_to(diameter, count), np.broadcast_to(density, count)
    with open(path, "w") as file:
        file.write(f"{title}\n\n{count} atoms\n{kind.max()} atom types\n\n")
        for axis, begin, end in zip("xyz", low, high):
            file.write(f"{begin:.17g} {end:.17g} {axis}lo {axis}hi\n")
        file.write("\nAtoms\n\n")
        number = np.arange(1, count + 1)
        np.savetxt(file, np.column_stack([number, kind, diameter, density, place]),
                   "%d %d" + 5 * " %.17g")
        file.write("\nVelocities\n\n")
        np.savetxt(file, np.column_stack([number, velocity, np.zeros((count, 3))]),
                   "%d" + 6 * " %.17g")


def read_log(path):
    """The rows of the last run's thermo output."""
    rows, width = [], 0
    for line in open(path):
        words = line.split()
        if words and words[0] == "Step":
            rows, width = [], len(words)
        elif len(words) == width and words and words[0].isdigit():
            rows.append([float(word) for word in words])
    return np.array(rows)
