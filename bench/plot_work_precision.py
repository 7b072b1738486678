"""Draws bench/results/work_precision.csv and puts its table into bench/README.md.

SPDX-License-Identifier: BSD-3-Clause
"""
import csv
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from readme import replace_section

LEVELS = (1e-2, 1e-4, 1e-6)


def read(path):
    with open(path) as file:
        about = file.readline().lstrip("# ").strip()
        rows = list(csv.DictReader(file))
    for row in rows:
        for key in ("prox", "tolerance", "products", "seconds", "E", "E_eps"):
            row[key] = float(row[key])
        row["error"] = row["E_eps"] if row["prox"] > 0 else row["E"]
    return about, rows


def first_below(rows, level, what):
    """What the first solve took whose residual is at most `level`; None where none got there."""
    return next((row[what] for row in rows if row["error"] <= level), None)


def cells(rows, what, form):
    found = (first_below(rows, level, what) for level in LEVELS)
    return " / ".join("-" if value is None else format(value, form) for value in found)


def main():
    path = pathlib.Path(sys.argv[1])
    about, rows = read(path)
    runs = list(dict.fromkeys((r["scene"], r["start"]) for r in rows))
    methods = list(dict.fromkeys((r["method"], r["friction"]) for r in rows))

    def of(run, method):
        return [r for r in rows
                if (r["scene"], r["start"]) == run and (r["method"], r["friction"]) == method]

    figure, axes = plt.subplots(2, len(runs), figsize=(3.6 * len(runs), 7), squeeze=False,
                                sharey=True)
    for column, run in zip(axes.T, runs):
        for axis, what in zip(column, ("products", "seconds")):
            for number, method in enumerate(methods):
                points = [(r[what], r["error"]) for r in of(run, method)]
                style = "o-" if method[1] == "convex" else "s--"
                axis.loglog(*zip(*points), style, color=f"C{number}", markersize=4,
                            label=" ".join(method))
            axis.set_xlabel(what)
            axis.grid(alpha=0.3)
        column[0].set_title(f"{run[0]}, {run[1]}")
    for row in axes:
        row[0].set_ylabel("E")
    axes[0][0].legend(fontsize=7)
    figure.tight_layout()
    figure.savefig(path.with_suffix(".png"), dpi=90)

    lines = [f"{about}.", ""]
    for title, what, form in (("products", "products", ".0f"), ("seconds", "seconds", ".2g")):
        lines += ["| " + title + " | " + " | ".join(" ".join(run) for run in runs) + " |",
                  "|---" * (len(runs) + 1) + "|"]
        for method in methods:
            lines.append(f"| {' '.join(method)} | "
                         + " | ".join(cells(of(run, method), what, form) for run in runs) + " |")
        lines.append("")
    lines.append("`accelerated` over `apgd`, convex, seconds to E = 1e-4 (where `apgd` does not")
    lines.append("get there in 4,000 products: at least): "
                 + "; ".join(ratio(of, run) for run in runs) + ".")
    replace_section(path.parent.parent / "README.md", "work_precision", "\n".join(lines))


def ratio(of, run):
    ours = first_below(of(run, ("accelerated", "convex")), 1e-4, "seconds")
    theirs = of(run, ("apgd", "convex"))
    reached = first_below(theirs, 1e-4, "seconds")
    if ours is None:
        return f"{' '.join(run)} neither"
    times = (reached or theirs[-1]["seconds"]) / ours
    return f"{' '.join(run)} {'' if reached else '> '}{times:.1f}"


if __name__ == "__main__":
    main()
