# What is left of piles at the end of a run: the largest remnant by contact and by gravity.
# SPDX-License-Identifier: BSD-3-Clause
"""The rules are those of src/analysis/clumps.cpp: bodies closer than the range of cohesion hang
together; the heaviest such clump then takes every body that its gravity, as of a point mass,
holds."""
import tomllib

import h5py
import numpy as np

G = 6.67430e-11


def last_frame(folder, skip_group=None):
    """Positions, velocities, radii, masses at the end of the run; without the bodies of a group,
    such as a planet."""
    with h5py.File(folder / "trajectory.h5") as file:
        rows = file["particles/all"]
        keep = rows["group"][:] != skip_group if skip_group is not None else slice(None)
        return [rows["position/value"][-1][keep], rows["velocity/value"][-1][keep],
                rows["radius"][:][keep],
                rows["mass"][:][keep]]


def results(folder):
    with open(folder / "results.toml", "rb") as file:
        return tomllib.load(file)


def clump_names(position, radius, reach):
    """Of each body the smallest index that a chain of gaps of at most `reach` (m) joins to it."""
    name = np.arange(len(radius))
    pairs = []
    for k in range(len(radius)):
        gap = np.linalg.norm(position[k + 1:] - position[k], axis=1) - radius[k + 1:] - radius[k]
        pairs.append(
            np.stack([np.full((gap <= reach).sum(), k), k + 1 + np.flatnonzero(gap <= reach)],
                     axis=1))
    pairs = np.concatenate(pairs)
    while True:
        before = name.copy()
        low = np.minimum(name[pairs[:, 0]], name[pairs[:, 1]])
        np.minimum.at(name, pairs[:, 0], low)
        np.minimum.at(name, pairs[:, 1], low)
        name = name[name]
        if np.array_equal(name, before):
            return name


def largest_remnant(position, velocity, radius, mass, reach=0.01):
    """Which bodies belong to it."""
    name = clump_names(position, radius, reach)
    weight = np.bincount(name, mass)
    inside = name == np.argmax(weight)
    while True:
        total = mass[inside].sum()
        middle, drift = (np.average(x[inside], axis=0, weights=mass[inside])
                         for x in (position, velocity))
        energy = np.sum((velocity - drift) ** 2, axis=1) / 2
        distance = np.linalg.norm(position - middle, axis=1)
        bound = energy * distance < G * (total + mass)
        if not np.any(bound & ~inside):
            return inside
        inside |= bound


def axes(position, mass):
    """m, full axes of the uniform ellipsoid with the same second moments, largest first."""
    x = position - np.average(position, axis=0, weights=mass)
    moments = np.linalg.eigvalsh((mass[:, None] * x).T @ x / mass.sum())
    return 2 * np.sqrt(5 * moments[::-1])
