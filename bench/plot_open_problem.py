"""Draws E against products of the open problem: plot_open_problem.py CSV, which is also put as a
table into bench/README.md.

SPDX-License-Identifier: BSD-3-Clause
"""
import csv
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

from readme import replace_section


def main(path):
    path = pathlib.Path(path)
    with open(path) as file:
        about = file.readline().lstrip("# ").strip()
        rows = list(csv.DictReader(file))
    curves = {}
    for row in rows:
        curves.setdefault((row["friction"], row["age"], row["way"]), []).append(
            (int(row["products"]), float(row["E"])))
    figure, axes = plt.subplots(1, 2, figsize=(11, 4.2), sharey=True, layout="constrained")
    lines = [about, "",
             "| friction | pile | way | products to E = 1e-2 | 1e-3 | 1e-4 | 1e-5 | 1e-6 | lowest "
             "E |",
             "|---|---|---|--:|--:|--:|--:|--:|--:|"]
    for (friction, age, way), points in curves.items():
        panel = axes[int(friction == "coulomb")]
        panel.loglog(*zip(*points), "-" if age == "just settled" else "--",
                     label=f"{way}, {age}", lw=1.4)
        panel.set(title=f"{friction} friction", xlabel="products", ylim=(1e-9, 1))
        reached = [next((str(n) for n, E in points if E <= goal), "-")
                   for goal in (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)]
        lines.append(f"| {friction} | {age} | {way} | " + " | ".join(reached)
                     + f" | {min(E for _, E in points):.1e} |")
    axes[0].set_ylabel("E, true residual")
    for panel in axes:
        panel.grid(alpha=0.3)
    axes[1].legend(fontsize=7)
    figure.savefig(path.with_suffix(".png"), dpi=120)
    replace_section(pathlib.Path(__file__).resolve().parent / "README.md", "open problem",
                    "\n".join(lines))


if __name__ == "__main__":
    main(sys.argv[1])
