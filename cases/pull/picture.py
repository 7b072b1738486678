# The net force on each body against time, and the table of the runs: picture.py OUT_FOLDER
# SPDX-License-Identifier: BSD-3-Clause
"""Reads OUT_FOLDER/pull-2, -8, -64 and -512; writes forces.png and results.md beside this script.

The net force over an interval is m dv / dt between two snapshots, contacts included; gravity's part
is m times the stored acceleration."""
import pathlib
import sys
import tomllib

import h5py
import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

HERE = pathlib.Path(__file__).parent
G = 6.67430e-11
BLUE, ORANGE, GREY = "#2f6db3", "#d9822b", "#8a94a3"


def time_of_fall(start, end, mass):
    """s, of two bodies from rest at distance `start` to distance `end` (m); `mass`: of both, kg."""
    x = end / start
    return np.sqrt(start**3 / (2 * G * mass)) * (np.sqrt(x * (1 - x)) + np.arccos(np.sqrt(x)))


def read(folder):
    with h5py.File(folder / "trajectory.h5") as file:
        rows = file["particles/all"]
        run = {key: rows[f"{key}/value"][:] for key in ("position", "velocity", "acceleration")}
        run |= {"time": rows["position/time"][:], "mass": rows["mass"][:],
                "radius": rows["radius"][:]}
    with open(folder / "results.toml", "rb") as file:
        run["results"] = tomllib.load(file)
    return run


def forces(run):
    """Middle of each interval (s); net force and gravity on each body in it (N)."""
    time, mass = run["time"], run["mass"][None, :, None]
    net = mass * np.diff(run["velocity"], axis=0) / np.diff(time)[:, None, None]
    pull = mass * run["acceleration"]
    return (time[1:] + time[:-1]) / 2, np.linalg.norm(net, axis=2), np.linalg.norm(pull, axis=2)


def first_contact(folder):
    """s: the instant of the first row of the series with a contact."""
    with open(folder / "series.csv") as file:
        names = file.readline().strip().split(",")
    rows = np.loadtxt(folder / "series.csv", delimiter=",", skiprows=1)
    return rows[np.argmax(rows[:, names.index("contacts")] > 0), names.index("time")]


def picture(runs):
    figure, axes = plt.subplots(2, 2, figsize=(12, 7), layout="constrained")
    for panel, (count, run) in zip(axes.flat, runs.items()):
        middle, net, pull = forces(run)
        for values, time, color, name in ((net, middle, BLUE, "net"),
                                          (pull, run["time"], ORANGE, "gravity")):
            low, mid, high = np.quantile(np.maximum(values, 1e-3), (0, 0.5, 1), axis=1)
            panel.fill_between(time / 60, low, high, color=color, alpha=0.25, lw=0)
            panel.plot(time / 60, mid, color=color, lw=1.2,
                       label=f"{name}: median, and all between")
        panel.set(yscale="log", ylim=(max(pull.min() / 30, 1e-2), 3 * max(net.max(), pull.max())),
                  title=f"{count} bodies", xlabel="time (min)", ylabel="force on a body (N)")
        panel.grid(color="#e4e8ee")
        panel.legend(fontsize=8, frameon=False, loc="lower right" if count == 2 else "best")
    figure.savefig(HERE / "forces.png", dpi=110)


def main(out):
    runs = {count: read(out / f"pull-{count}") for count in (2, 8, 64, 512)}
    picture(runs)
    lines = ["| bodies | radius, m | first contact, s | settled after, s | packing in the "
             "half-mass radius | "
             "drift of momentum | energy unexplained, of the dissipated |",
             "|--:|--:|--:|--:|--:|--:|--:|"]
    for count, run in runs.items():
        results = run["results"]
        lines.append(f"| {count} | {run['radius'][0]:g} | "
                     f"{first_contact(out / ('pull-' + str(count))):g} | {run['time'][-1]:g} | "
                     f"{results['pile']['packing_fraction']:.3f} | "
                     f"{results['conservation']['linear']:.1e} | "
                     f"{results['conservation']['energy_unexplained']:.1e} |")
    two = runs[2]
    distance = np.linalg.norm(two["position"][:, 0] - two["position"][:, 1], axis=1)
    exact = time_of_fall(100.0, 80.0, two["mass"].sum())
    worst = 0.0
    for time, d in zip(two["time"], distance):
        if time < 0.97 * exact and d < 100:
            worst = max(worst, abs(time - time_of_fall(100.0, d, two["mass"].sum())))
    lines += ["",
              f"Two bodies fall from 100 m to contact at 80 m in {exact:.1f} s by the formula; the "
              f"run's places are "
              f"reached within {worst:.2g} s of their times in the formula (steps of 10 s)."]
    (HERE / "results.md").write_text("# Falling together: the runs\n"
                                     "Written by `cases/pull/picture.py`.\n\n" + "\n".join(lines)
                                     + "\n")


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]))
