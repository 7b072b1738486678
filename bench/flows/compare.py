#!/usr/bin/python3
"""Loads on the silo's base and profiles of the chute, by both programs, into section flows of
../README.md.

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
from lammps_files import read_log  # noqa: E402
from readme import origin, replace_section  # noqa: E402

seeds = range(1, int(sys.argv[1]) + 1)
weight = 3000 * math.pi / 6  # N, of the silo's grains


def load_of_spall(seed):
    """Mean share of the weight on the base in the last quarter of the run, while it goes down."""
    rows = list(csv.DictReader(open(f"silo{seed}/series.csv")))
    return -statistics.mean(float(r["silo_2_force_z"]) for r in rows[3 * len(rows) // 4:]) / weight


def load_of_lammps(seed):
    """The same, of the second half of LAMMPS's second run."""
    load = read_log(f"silo{seed}.log")[:, 2]
    return -load[len(load) // 2:].mean() / weight


def profile(frames):
    """Mean speed (m/s) and number of grains in layers of 2 m, of the second half of the frames."""
    frames = list(frames)
    z, v = (np.concatenate([frame[k] for frame in frames[len(frames) // 2:]]) for k in (0, 1))
    edges = np.arange(1, 48, 2.0)
    count, _ = np.histogram(z, edges)
    speed, _ = np.histogram(z, edges, weights=v)
    return edges, speed / np.maximum(count, 1), count / (len(frames) - len(frames) // 2)


def frames_of_spall(run):
    with h5py.File(f"chute{run}/trajectory.h5") as file:
        bodies = file["particles/all"]
        flows = bodies["group"][()] == 0
        for k in range(bodies["position/value"].shape[0]):
            yield bodies["position/value"][k][flows, 2], bodies["velocity/value"][k][flows, 0]


def frames_of_lammps(run):
    lines = open(f"chute{run}.dump").read().split("\n")
    at = 0
    while at < len(lines) and lines[at]:
        count = int(lines[at + 3])
        rows = np.array(
            [[float(word) for word in line.split()] for line in lines[at + 9:at + 9 + count]])
        yield rows[:, 1], rows[:, 2]
        at += 9 + count


def spread(values):
    return statistics.stdev(values) if len(values) > 1 else math.nan


silo = {name: [of(seed) for seed in seeds]
        for name, of in (("Spall", load_of_spall), ("LAMMPS", load_of_lammps))}
ours, theirs = (statistics.mean(silo[name]) for name in ("Spall", "LAMMPS"))
text = [origin(1), "",
        f"Silo, {len(seeds)} starts, mean and scatter (one deviation): the base carries "
        f"{ours:.4f} ± {spread(silo['Spall']):.4f} of the weight by Spall, {theirs:.4f} ± "
        f"{spread(silo['LAMMPS']):.4f} "
        f"by LAMMPS: {ours / theirs:.3f}.", "",
        "Chute, two runs each with other roundings, means and how far the two are apart:", "",
        "| layer, m | grains, Spall | LAMMPS | v_x, Spall, m/s | LAMMPS | ratio |",
        "|---|--:|--:|--:|--:|--:|"]
flows = {name: [profile(of(run)) for run in (1, 2)]
         for name, of in (("Spall", frames_of_spall), ("LAMMPS", frames_of_lammps))}
edges = flows["Spall"][0][0]
v = {name: np.array([run[1] for run in runs]) for name, runs in flows.items()}
n = {name: np.array([run[2] for run in runs]) for name, runs in flows.items()}


def row(what, count, speed):
    mean = {name: speed[name].mean() for name in speed}
    cells = [f"{mean[name]:.3f} ({abs(speed[name][0] - speed[name][1]):.3f})"
             for name in ("Spall", "LAMMPS")]
    text.append(f"| {what} | {count['Spall'].mean():.0f} | {count['LAMMPS'].mean():.0f} | "
                f"{cells[0]} | {cells[1]} "
                f"| {mean['Spall'] / mean['LAMMPS']:.3f} |")


for k in range(len(edges) - 1):
    if min(n[name][:, k].min() for name in n) > 100:
        row(f"{edges[k]:g}–{edges[k + 1]:g}", {name: n[name][:, k] for name in n},
            {name: v[name][:, k] for name in v})
row("all", {name: n[name].sum(axis=1) for name in n},
    {name: (n[name] * v[name]).sum(axis=1) / n[name].sum(axis=1) for name in n})
replace_section(here.parent / "README.md", "flows", "\n".join(text))
print("\n".join(text))
