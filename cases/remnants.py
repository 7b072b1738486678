# What is left of piles at the end of a run: the largest remnant by contact and by gravity.
# SPDX-License-Identifier: BSD-3-Clause
"""The rules are those of src/analysis/clumps.cpp: bodies closer than the range of cohesion hang
together; the heaviest such clump then takes every body that its gravity, as of a point mass,
holds."""
import concurrent.futures
import os
import pathlib
import tomllib

import h5py
import numpy as np
from program import spall

G = 6.67430e-11
SEEDS = (1, 2, 3, 4, 5)  # of the piles of 1,000 boulders


def last_frame(folder, skip_group=None):
    """Positions, velocities, radii, masses at the end of the run; without the bodies of a group,
    such as a planet."""
    with h5py.File(folder / "trajectory.h5") as file:
        rows = file["particles/all"]
        keep = rows["group"][:] != skip_group if skip_group is not None else slice(None)
        return [rows["position/value"][-1][keep], rows["velocity/value"][-1][keep],
                rows["radius"][:][keep], rows["mass"][:][keep]]


def pile(seed, settles=True):
    """The folder of the settled pile of a seed, which is made where it is missing."""
    folder = pathlib.Path("out/pile" if seed == 1 else f"out/pile-{seed}")
    if settles and not (folder / "after_settling.h5").exists():
        spall("run", "cases/pile/case.toml", "--out", folder, "--overwrite",
              changes=[f"seed={seed}"], ranks=2, shows=True)
    return folder


def run_all(case, runs, groups):
    """Runs what is missing of [(folder, seed, changes)], as many at a time as there are cores, each
    on one rank; `groups` of the case get the pile of the seed."""
    missing = [run for run in runs if not (run[0] / "results.toml").exists()]
    for seed in sorted({seed for _, seed, _ in missing if groups}):
        pile(seed)

    def run(folder, seed, changes):
        changes = [*changes, *(f"groups.{group}.packing.file=../../{pile(seed)}/after_settling.h5"
                               for group in groups)]
        spall("run", case, "--out", folder, "--overwrite", changes=changes)
        print(folder, flush=True)

    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for done in [pool.submit(run, *one) for one in missing]:
            done.result()


def scatter(values, digits=2):
    """Mean ± standard deviation over the seeds, with as many decimals as the deviation has of
    `digits` figures. Seeds without a value (nan) are left out, and how many have one is told."""
    every = np.asarray(values, dtype=float)
    values = every[np.isfinite(every)]
    if len(values) == 0:
        return "none"
    if len(values) < len(every):
        return f"{scatter(values, digits)} ({len(values)} of {len(every)})"
    mean = values.mean()
    if len(values) < 2:
        return f"{mean:.2g}"
    spread = values.std(ddof=1)
    if spread <= 1e-9 * abs(mean):
        return f"{mean:.4g} ± 0"
    decimals = max(0, digits - 1 - int(np.floor(np.log10(spread))))
    return f"{mean:.{decimals}f} ± {spread:.{decimals}f}"


def commits(folders):
    """Of the runs, as their results tell."""
    return ", ".join(sorted({results(folder)["provenance"]["commit"] for folder in folders}))


def results(folder):
    with open(folder / "results.toml", "rb") as file:
        return tomllib.load(file)


def clump_names(position, radius, reach):
    """Of each body the smallest index that a chain of gaps of at most `reach` (m) joins to it."""
    name = np.arange(len(radius))
    pairs = []
    for k in range(len(radius)):
        gap = np.linalg.norm(position[k + 1:] - position[k], axis=1) - radius[k + 1:] - radius[k]
        pairs.append(np.stack([np.full((gap <= reach).sum(), k),
                               k + 1 + np.flatnonzero(gap <= reach)], axis=1))
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
