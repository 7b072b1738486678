#!/usr/bin/python3
"""Turns a LAMMPS dump (id x y z ...) of a periodic packing of spheres of 1 m into a data file.

SPDX-License-Identifier: BSD-3-Clause
usage: replicate.py DUMP DATA COPIES [SPEED]: so many copies of the box along each axis; root mean
square of each component of the velocities, m/s
"""
import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
from lammps_files import write_spheres  # noqa: E402

dump, data, copies = sys.argv[1], sys.argv[2], int(sys.argv[3])
speed = float(sys.argv[4]) if len(sys.argv) > 4 else 0
lines = open(dump).read().split("\n", 9)  # the first frame's head; its rows are the rest
low, high = np.array([[float(word) for word in line.split()] for line in lines[5:8]]).T
size = high - low
place = np.array(lines[9].split(), float).reshape(int(lines[3]), -1)[:, 1:4]
place = (place - low) % size
steps = np.stack(np.meshgrid(*3 * [np.arange(copies)], indexing="ij"), -1).reshape(-1, 3)
place = np.concatenate([place + step * size for step in steps])
velocity = np.random.default_rng(1).normal(0, speed, place.shape)
velocity -= velocity.mean(0)
write_spheres(data, "spheres of 1 m", 3 * [0], copies * size, 1, 2500, place, velocity)
