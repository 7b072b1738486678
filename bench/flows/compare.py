#!/usr/bin/python3
"""Loads of the silo's base and profiles of the slope, by both programs, into section flows of ../README.md.

SPDX-License-Identifier: BSD-3-Clause
usage: compare.py SEEDS, in the folder of run_flows.sh
"""
import csv
import math
import pathlib
import statistics
import sys

import h5py
import numpy as np

here = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(here.parent))
from readme import origin, replace_section  # noqa: E402

seeds = range(1, int(sys.argv[1]) + 1)
weight = 3000 * math.pi / 6  # N, of the silo's grains


def base_of_spall(seed):
    """Mean share of the weight on the base in the last sixth of the run."""
    rows = list(csv.DictReader(open(f"silo{seed}/series.csv")))
    return -statistics.mean(float(r["base_force_z"]) for r in rows[5 * len(rows) // 6:]) / weight


def base_of_lammps(seed):
    lines = open(f"silo{seed}.log").read().split("\n")
    first = next(k for k, line in enumerate(lines) if line.startswith("Step"))
    rows = []
    for line in lines[first + 1:]:
        if line.startswith("Loop"):
            break
        rows.append(float(line.split()[2]))
    return statistics.mean(rows[5 * len(rows) // 6:]) / weight


def profile(frames):
    """Mean speed (m/s) and number of grains in layers of 1 m, of the second half of the frames."""
    frames = list(frames)
    z, v = (np.concatenate([frame[k] for frame in frames[len(frames) // 2:]]) for k in (0, 1))
    edges = np.arange(0.5, 12.5)
    count, _ = np.histogram(z, edges)
    speed, _ = np.histogram(z, edges, weights=v)
    return speed / np.maximum(count, 1), count / (len(frames) - len(frames) // 2)


def frames_of_spall(seed):
    for path in sorted(pathlib.Path(f"slope{seed}").glob("*.h5")):
        with h5py.File(path) as file:
            if "particles" not in file:
                continue
            bodies = file["particles/bodies"] if "bodies" in file["particles"] else next(iter(file["particles"].values()))
            place, velocity = bodies["position/value"], bodies["velocity/value"]
            for k in range(place.shape[0]):
                moves = ~np.all(velocity[k] == 0, axis=1)
                yield place[k][moves, 2], velocity[k][moves, 0]


def frames_of_lammps(seed):
    lines = open(f"slope{seed}.dump").read().split("\n")
    at = 0
    while at < len(lines) and lines[at]:
        count = int(lines[at + 3])
        rows = np.array([[float(word) for word in line.split()] for line in lines[at + 9:at + 9 + count]])
        yield rows[:, 1], rows[:, 2]
        at += 9 + count


def spread(values):
    return statistics.stdev(values) if len(values) > 1 else math.nan


silo = {name: [of(seed) for seed in seeds] for name, of in (("Spall", base_of_spall), ("LAMMPS", base_of_lammps))}
slope = {name: [profile(of(seed)) for seed in seeds]
         for name, of in (("Spall", frames_of_spall), ("LAMMPS", frames_of_lammps))}
mean = {name: np.mean([speed for speed, _ in runs], axis=0) for name, runs in slope.items()}
grains = {name: np.mean([count for _, count in runs], axis=0) for name, runs in slope.items()}
flux = {name: [float((speed * count).sum()) for speed, count in runs] for name, runs in slope.items()}
text = [origin(1) + f"; {len(seeds)} starts, mean and scatter (one deviation) of them", "",
        "| | Spall | LAMMPS | ratio |", "|---|--:|--:|--:|"]


def row(what, values, form):
    ours, theirs = (statistics.mean(values[name]) for name in ("Spall", "LAMMPS"))
    text.append(f"| {what} | {ours:{form}} ± {spread(values['Spall']):{form}} | {theirs:{form}} ± "
                f"{spread(values['LAMMPS']):{form}} | {ours / theirs:.3f} |")


row("silo: share of the weight on the base", silo, ".4f")
row("slope: grains times speed, m/s", flux, ".0f")
for layer in range(len(mean["Spall"])):
    if min(grains[name][layer] for name in grains) > 20:
        row(f"slope: speed between {layer + 0.5:g} and {layer + 1.5:g} m, m/s",
            {name: [speed[layer] for speed, _ in runs] for name, runs in slope.items()}, ".3f")
        row(f"slope: grains between {layer + 0.5:g} and {layer + 1.5:g} m",
            {name: [count[layer] for _, count in runs] for name, runs in slope.items()}, ".1f")
replace_section(here.parent / "README.md", "flows", "\n".join(text))
print("\n".join(text))
