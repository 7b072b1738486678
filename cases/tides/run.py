# A pile on parabolas past a planet: what is left, and the class of the encounter.
# SPDX-License-Identifier: BSD-3-Clause
"""run.py [--only-table]: runs what is missing in out/, writes results.md and piles.png beside this
script."""
import pathlib
import sys

import matplotlib
import numpy as np

HERE = pathlib.Path(__file__).parent
sys.path[:0] = [str(HERE.parent), str(HERE.parents[1] / "src/output")]
from remnants import (SEEDS, axes, commits, largest_remnant, last_frame,  # noqa: E402
                      run_all, scatter)
from report_figures import SKY, rock, scale_bar, show  # noqa: E402
from report_spheres import Camera, render  # noqa: E402

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

APPROACHES = (1.2, 1.5, 1.7, 1.85, 1.88, 1.92, 2.0, 2.1, 2.2)  # planet radii
PLANET, START = 6371e3, 6 * 6371e3  # m
MU = 6.67430e-11 * 5.972e24


def state(approach):
    """Place and velocity at START on the way in along a parabola whose closest approach lies on
    +x."""
    q = approach * PLANET
    nu = -2 * np.arctan(np.sqrt(START / q - 1))
    out, along = np.array([np.cos(nu), np.sin(nu), 0]), np.array([-np.sin(nu), np.cos(nu), 0])
    return START * out, np.sqrt(MU / (2 * q)) * (np.sin(nu) * out + (1 + np.cos(nu)) * along)


def kind(part):
    """Richardson, Bottke & Love 1998 (Icarus 134:47)."""
    return "S" if part < 0.5 else "B" if part < 0.9 else "M"


def folder_of(approach, seed):
    return pathlib.Path(f"out/tides-{approach}-{seed}")


def read(approach, seed):
    position, velocity, radius, mass = last_frame(folder_of(approach, seed), skip_group=0)
    inside = largest_remnant(position, velocity, radius, mass)
    return {"part": mass[inside].sum() / mass.sum(), "whole": axes(position, mass)[0],
            "own": axes(position[inside], mass[inside]), "frame": (position, radius)}


def main():
    runs = []
    for approach in APPROACHES:
        x, v = state(approach)
        runs += [(folder_of(approach, seed), seed,
                  [f"groups.pile.volume.center={x.tolist()}",
                   f"groups.pile.velocity={v.tolist()}"])
                 for seed in SEEDS]
    if "--only-table" not in sys.argv:
        run_all("cases/tides/case.toml", runs, ["pile"])
    there = {approach: [read(approach, seed) for seed in SEEDS
                        if (folder_of(approach, seed) / "results.toml").exists()]
             for approach in APPROACHES}
    there = {approach: rows for approach, rows in there.items() if rows}
    made = commits(folder for folder, _, _ in runs if (folder / "results.toml").exists())
    lines = ["# A pile passes a planet: the runs",
             f"Written by `cases/tides/run.py`, runs by commit {made}; 8 h after the start at 6 "
             "planet radii; mean ± standard deviation over piles of other seeds.", "",
             "| closest approach, planet radii | piles | largest remnant | least, most | classes "
             "| its longest, middle, shortest axis, m | length of all, m |",
             "|--:|--:|--:|--:|---|--:|--:|"]
    for approach, rows in there.items():
        parts = [row["part"] for row in rows]
        lines.append(f"| {approach} | {len(rows)} | {scatter(parts)} | {min(parts):.2f}, "
                     f"{max(parts):.2f} | {' '.join(sorted(map(kind, parts)))} | "
                     + ", ".join(scatter([row["own"][k] for row in rows]) for k in range(3))
                     + f" | {scatter([row['whole'] for row in rows])} |")
    (HERE / "results.md").write_text("\n".join(lines) + "\n")
    rows = [(approach, some[0]["part"], *some[0]["frame"]) for approach, some in there.items()]
    figure, panels = plt.subplots(len(rows), 1, figsize=(12, 2.6 * len(rows)),
                                  facecolor=tuple(SKY), squeeze=False)
    for panel, (approach, part, position, radius) in zip(panels[:, 0], rows):
        middle = np.median(position, axis=0)
        long_axis = np.linalg.svd(position - middle, full_matrices=False)[2][0]
        along = (position - middle) @ long_axis
        up = np.cross([0, 0, 1.0], long_axis)
        up /= np.linalg.norm(up)
        across = (position - middle) @ up
        middle = middle + (long_axis * (along.min() + along.max())
                           + up * (across.min() + across.max())) / 2
        edge = 2 * radius.max()
        width = 1.06 * max(np.ptp(along) + edge, 5 * (np.ptp(across) + edge))
        camera = Camera(np.array([0, 0, 1.0]), up, middle, width, width / 5, 1100)
        show(panel, camera, render(camera, position, radius, rock(len(radius)), SKY))
        scale_bar(panel, camera)
        panel.set_title(f"{approach} planet radii: {kind(part)}", color="white", loc="center",
                        fontsize=10)
    figure.subplots_adjust(0.005, 0.01, 0.995, 1 - 0.12 / len(rows), hspace=0.14)
    figure.savefig(HERE / "piles.png", dpi=110, facecolor=tuple(SKY))


if __name__ == "__main__":
    main()
