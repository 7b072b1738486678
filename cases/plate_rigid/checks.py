"""The rigid plate from start to end in steps of half, once and twice a radius of flight: what must
hold.

    python3 cases/plate_rigid/checks.py [--across 10] [--ranks 2] [--tolerance 1e-3] [--table]

At 40 across it is the thesis's plate. Rows are kept in cases/plate_rigid/checks.csv and make the
README's table.
SPDX-License-Identifier: BSD-3-Clause
"""
import argparse
import csv
import sys
import tomllib
from pathlib import Path

import h5py
import numpy as np

HERE = Path(__file__).parent
ROOT = HERE.parent.parent
sys.path += [str(HERE.parent), str(ROOT / "bench")]
from program import PROGRAM, spall  # noqa: E402
from readme import replace_section  # noqa: E402

DIAMETER, SPEED = 9.4744e-3, 6700.0  # of the sphere, m and m/s
KEY = ["across", "tolerance", "part"]


def run(options, part):
    d = DIAMETER / options.across
    width, depth = 5.1 * DIAMETER, 0.425 * DIAMETER  # 204 and 17 of 40
    step = part * d / 2 / SPEED
    folder = ROOT / f"out/plate_rigid/{options.across:g}-{options.tolerance:g}-{part:g}"
    changes = [f"groups.plate.volume.size=[{width}, {width}, {depth}]",
               f"groups.plate.volume.center=[0, 0, {-depth / 2}]",
               f"groups.plate.packing.diameter={d}",
               f"groups.ball.volume.center=[0, 0, {DIAMETER / 2 + d / 2}]",
               f"groups.ball.packing.diameter={d}",
               f"contact.cohesion_range={0.01 * d}", f"solver.tolerance={options.tolerance}",
               "solver.max_iterations=3000", f"phases.impact.step={step}",
               "output.series_every=0",
               "output.snapshot_every=1"]
    spall("run", HERE / "case.toml", "--out", folder, "--overwrite", changes=changes,
          ranks=options.ranks, program=options.program)
    results = tomllib.loads((folder / "results.toml").read_text())
    with (folder / "series.csv").open() as file:
        series = list(csv.DictReader(file))
    kinetic, bonds, unexplained = (np.array([float(row[key]) for row in series])
                                   for key in ("kinetic", "bonds", "unexplained"))
    with h5py.File(folder / "after_impact.h5") as file:
        fastest = np.linalg.norm(file["bodies/velocity"], axis=1).max()
        bodies = len(file["bodies/mass"])
        scalars = dict(zip(file["scalars/names"][()].decode().split(), file["scalars/values"][:]))
    # What cohesion's impulses did to the bodies, beside what the bonds gave for it within their
    # range.
    beyond = scalars["ledger.cohesion_work"] + bonds[-1] - bonds[0]
    return {"across": f"{options.across:g}", "tolerance": f"{options.tolerance:g}",
            "part": f"{part:g}",
            "bodies": bodies, "steps": len(kinetic),
            "front": f"{results['debris']['front_over_speed']:.4f}",
            "radial": f"{results['debris']['radial_over_speed']:.4f}",
            "hole": f"{results['debris']['hole_over_diameter']:.3f}",
            "fastest": f"{fastest / SPEED:.4f}",
            "rise": f"{max(0, np.diff(kinetic).max()) / kinetic[0]:.1e}",
            "left": f"{kinetic[-1] / kinetic[0]:.4f}",
            "beyond": f"{beyond / kinetic[0]:.4f}",
            "unexplained": f"{(unexplained[-1] - beyond) / kinetic[0]:.1e}",
            "momentum": f"{results['conservation']['linear']:.1e}",
            "seconds": f"{results['time']['total_s']:.0f}",
            "commit": results["provenance"]["commit"]}


def table(rows):
    lines = ["| across | bodies | residual asked | step, r/v | steps | front / V | radial / V | "
             "hole / D | fastest body / V "
             "| largest rise of kinetic energy in a step | kinetic energy left | cohesion beyond "
             "its range | energy unexplained beside | momentum drift | s |",
             "|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|"]
    for r in sorted(rows, key=lambda r: [float(r[key]) for key in KEY]):
        lines.append(f"| {r['across']} | {int(r['bodies']):,} | {r['tolerance']} | {r['part']} | "
                     f"{r['steps']} | "
                     f"{float(r['front']):.3f} | {float(r['radial']):.3f} | {float(r['hole']):.2f} "
                     f"| "
                     f"{float(r['fastest']):.2f} | {r['rise']} | {float(r['left']):.3f} | "
                     f"{float(r['beyond']):.3f} | {r['unexplained']} | {r['momentum']} | "
                     f"{r['seconds']} |")
    commits = ", ".join(sorted({row["commit"] for row in rows}))
    return "\n".join([*lines, "",
                      f"Shares of the impact's speed V, energy and momentum. Commits {commits}."])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--across", type=float, default=10)
    parser.add_argument("--tolerance", type=float, default=1e-3)
    parser.add_argument("--parts", type=float, nargs="+", default=[2, 1, 0.5],
                        help="of a radius of flight")
    parser.add_argument("--ranks", type=int, default=2)
    parser.add_argument("--program", type=Path, default=PROGRAM)
    parser.add_argument("--table", action="store_true", help="run nothing")
    options = parser.parse_args()
    path = HERE / "checks.csv"
    rows = list(csv.DictReader(path.open())) if path.exists() else []
    for part in [] if options.table else options.parts:
        row = run(options, part)
        print(*row.values(), flush=True)
        rows = [r for r in rows if any(r[key] != row[key] for key in KEY)] + [row]
        with path.open("w", newline="") as file:
            writer = csv.DictWriter(file, list(row))
            writer.writeheader()
            writer.writerows(rows)
    replace_section(HERE / "README.md", "checks", table(rows))


if __name__ == "__main__":
    main()
