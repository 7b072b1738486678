#!/usr/bin/python3
"""Loads on the silo's base and profiles of the chute, by both programs, into section flows of ../README.md.

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


def load_of_spall(seed):
    """Mean share of the weight on the base in the last quarter of the run, while it goes down."""
    rows = list(csv.DictReader(open(f"silo{seed}/series.csv")))
    return -statistics.mean(float(r["silo_2_force_z"]) for r in rows[3 * len(rows) // 4:]) / weight


def load_of_lammps(seed):
    lines = open(f"silo{seed}.log").read().split("\n")
    last = max(k for k, line in enumerate(lines) if line.startswith("Step"))  # the header of the last run
    rows = []
    for line in lines[last + 1:]:
        if line.startswith("Loop"):
            break
        rows.append(float(line.split()[2]))
    return -statistics.mean(rows[len(rows) // 2:]) / weight


def profile(frames):
    """Mean speed (m/s) and number of grains in layers of 2 m, of the second half of the frames."""
    frames = list(frames)
    z, v = (np.concatenate([frame[k] for frame in frames[len(frames) // 2:]]) for k in (0, 1))
    edges = np.arange(1, 48, 2.0)
    count, _ = np.histogram(z, edges)
    speed, _ = np.histogram(z, edges, weights=v)
    return edges, speed / np.maximum(count, 1), count / (len(frames) - len(frames) // 2)


def frames_of_spall():
    with h5py.File("chute/trajectory.h5") as file:
        bodies = file["particles/all"]
        flows = bodies["group"][()] == 0
        for k in range(bodies["position/value"].shape[0]):
            yield bodies["position/value"][k][flows, 2], bodies["velocity/value"][k][flows, 0]


def frames_of_lammps():
    lines = open("chute.dump").read().split("\n")
    at = 0
    while at < len(lines) and lines[at]:
        count = int(lines[at + 3])
        rows = np.array([[float(word) for word in line.split()] for line in lines[at + 9:at + 9 + count]])
        yield rows[:, 1], rows[:, 2]
        at += 9 + count


def spread(values):
    return statistics.stdev(values) if len(values) > 1 else math.nan


silo = {name: [of(seed) for seed in seeds] for name, of in (("Spall", load_of_spall), ("LAMMPS", load_of_lammps))}
ours, theirs = (statistics.mean(silo[name]) for name in ("Spall", "LAMMPS"))
text = [origin(1), "",
        f"Silo, {len(seeds)} starts, mean and scatter (one deviation): the base carries "
        f"{ours:.4f} ± {spread(silo['Spall']):.4f} of the weight by Spall, {theirs:.4f} ± {spread(silo['LAMMPS']):.4f} "
        f"by LAMMPS: {ours / theirs:.3f}.", "",
        "| layer of the chute, m | grains, Spall | LAMMPS | v_x, Spall, m/s | LAMMPS | ratio |", "|---|--:|--:|--:|--:|--:|"]
edges, v, n = profile(frames_of_spall())
_, v_peer, n_peer = profile(frames_of_lammps())
for k in range(len(v)):
    if min(n[k], n_peer[k]) > 100:
        text.append(f"| {edges[k]:g}–{edges[k + 1]:g} | {n[k]:.0f} | {n_peer[k]:.0f} | {v[k]:.4f} | {v_peer[k]:.4f} "
                    f"| {v[k] / v_peer[k]:.4f} |")
text.append(f"| all | {n.sum():.0f} | {n_peer.sum():.0f} | {(n * v).sum() / n.sum():.4f} "
            f"| {(n_peer * v_peer).sum() / n_peer.sum():.4f} "
            f"| {(n * v).sum() / n.sum() / ((n_peer * v_peer).sum() / n_peer.sum()):.4f} |")
replace_section(here.parent / "README.md", "flows", "\n".join(text))
print("\n".join(text))
