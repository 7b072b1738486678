"""Draws bench/results/gravity.csv and writes the tables beside it: error against time.

SPDX-License-Identifier: BSD-3-Clause
"""
import csv
import math
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

# Seconds on one core and rms force error of FDPS 7.1 (quadrupole, AVX-512) at opening angles 1.0,
# 0.7, 0.5, 0.3, and of a plain double direct sum (2.86 G interactions/s) on the machine where it
# was
# measured. Only ratios to the plain sum can be compared.
FDPS = {
    ("ball", 10307): [(0.0047, 6.3e-3), (0.0060, 1.9e-3), (0.0102, 3.6e-4), (0.0201, 6.5e-5)],
    ("ball", 100000): [(0.055, 7.8e-3), (0.072, 2.0e-3), (0.135, 4.1e-4), (0.320, 8.7e-5)],
    ("ball", 1000000): [(0.67, 1.1e-2), (0.91, 2.3e-3), (1.75, 5.2e-4), (4.54, 9.1e-5)],
    ("pile", 100000): [(0.097, 6.0e-3), (0.136, 1.2e-3), (0.304, 4.0e-4), (0.717, 5.8e-5)],
}
FDPS_PLAIN_RATE = 2.86e9


def read(path):
    with open(path) as file:
        about = file.readline().lstrip("# ").strip()
        rows = list(csv.DictReader(file))
    for row in rows:
        for key in row:
            if key != "set":
                row[key] = float(row[key])
    return about, rows


def speedup_at(points, error):
    """Log-log interpolation of (rms error, speed-up); extended by the last segment."""
    points = sorted((math.log(e), math.log(s)) for e, s in points)
    x = math.log(error)
    pairs = list(zip(points, points[1:]))
    (x0, y0), (x1, y1) = next((p for p in pairs if x <= p[1][0]), pairs[-1])
    return math.exp(y0 + (y1 - y0) * (x - x0) / (x1 - x0))


def main():
    path = pathlib.Path(sys.argv[1])
    about, rows = read(path)
    sets = list(dict.fromkeys((row["set"], int(row["bodies"])) for row in rows))

    figure, axes = plt.subplots(1, len(sets), figsize=(4 * len(sets), 3.6), squeeze=False)
    lines = [
        "### Gravity: error against time",
        "",
        f"{about}. `bench/run_gravity.sh build/release` makes these figures anew.",
        "",
        "Speed-up: time of the plain direct sum, in which every body meets every other, over the "
        "time",
        "of the tree, processor time of the slowest rank, measured in turns in one run. FDPS: its "
        "own speed-up over the same",
        "sum on the machine where it was measured, interpolated (below 6e-5: extrapolated).",
        "",
        "| set | bodies | rms error | tree, 1 rank | FDPS 7.1, 1 rank | ratio |",
        "|---|---|---|---|---|---|",
    ]
    for axis, key in zip(axes[0], sets):
        curves = {
            ranks: [(r["rms"], r["plain_s"] / r["tree_s"]) for r in rows
                    if (r["set"], int(r["bodies"])) == key and r["ranks"] == ranks]
            for ranks in (1, 2)
        }
        for ranks, points in curves.items():
            if points:
                axis.loglog(*zip(*points), "o-", label=f"tree, {ranks} rank{'s' * (ranks > 1)}")
        plain = key[1] ** 2 / FDPS_PLAIN_RATE
        fdps = [(error, plain / seconds) for seconds, error in FDPS.get(key, [])]
        if fdps:
            axis.loglog(*zip(*fdps), "s--", color="gray", label="FDPS 7.1, 1 rank")
            for error in (1e-3, 1e-4, 1e-5):
                ours, theirs = speedup_at(curves[1], error), speedup_at(fdps, error)
                lines.append(f"| {key[0]} | {key[1]:,} | {error:.0e} | {ours:.1f} | {theirs:.1f} |"
                             f" {ours / theirs:.2f} |")
        axis.set_title(f"{key[0]}, {key[1]:,} bodies")
        axis.set_xlabel("rms relative force error")
        axis.grid(alpha=0.3)
    axes[0][0].set_ylabel("speed-up over the plain sum\non as many ranks")
    axes[0][0].legend()
    figure.tight_layout()
    figure.savefig(path.with_suffix(".png"), dpi=120)

    lines += [
        "",
        "![error against time](gravity.png)",
        "",
        "| set | bodies | ranks | order | asked | rms | 99 % | max | tree, s | build, s |"
        " moments and exchange, s | walk, s | exact sum, s | bytes a body | net force | net torque "
        "|",
        "|" + "---|" * 16,
    ]
    for r in rows:
        lines.append(
            f"| {r['set']} | {int(r['bodies']):,} | {int(r['ranks'])} | {int(r['order'])} |"
            f" {r['asked']:.0e} | {r['rms']:.1e} | {r['p99']:.1e} | {r['max']:.1e} |"
            f" {r['tree_s']:.3g} | {r['build_s']:.3g} | {r['exchange_s']:.3g} |"
            f" {r['tree_s'] - r['build_s'] - r['exchange_s']:.3g} |"
            f" {r['direct_s']:.3g} | {r['bytes']:.0f} |"
            f" {r['net_force']:.0e} |"
            f" {r['net_torque']:.0e} |")
    lines += ["",
              "Net force: |sum F| / sum |F|; net torque: |sum x × F| / sum |x| |F|. The exact sum "
              "meets each pair once. Bytes a body: peak memory of an evaluation beyond what was "
              "there before, "
              "the field it returns (32 bytes) included.", ""]
    path.with_suffix(".md").write_text("\n".join(lines))


if __name__ == "__main__":
    main()
