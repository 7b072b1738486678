"""Puts what a run of cases/rest measured into its README: write_rest.py RUN_FOLDER

SPDX-License-Identifier: BSD-3-Clause
"""
import csv
import pathlib
import sys
import tomllib

from readme import origin, replace_section

NAMES = {1: "settling", 2: "rest", 3: "month"}


def norm(row, name):
    return sum(float(row[f"{name}_{axis}"]) ** 2 for axis in "xyz") ** 0.5


def main(folder):
    folder = pathlib.Path(folder)
    with open(folder / "results.toml", "rb") as file:
        results = tomllib.load(file)
    with open(folder / "series.csv") as file:
        rows = list(csv.DictReader(file))
    mass = results["pile"]["mass"]
    released = float(rows[0]["gravitational"]) - float(rows[-1]["gravitational"])
    lines = [origin(results["time"]["ranks"]), "",
             "| phase | steps | radius of gyration, change | kinetic energy at the end, of the "
             "potential energy released | speed of the centre of mass, m/s | E at the end |",
             "|---|--:|--:|--:|--:|--:|"]
    for phase, name in NAMES.items():
        part = [row for row in rows if int(float(row["phase"])) == phase]
        first, last = part[0], part[-1]
        gyration = float(last["gyration_radius"]) / float(first["gyration_radius"]) - 1
        lines.append(f"| {name} | {int(last['step']) - int(first['step'])} | {gyration:.1e} "
                     f"| {float(last['kinetic']) / released:.1e} "
                     f"| {norm(last, 'momentum') / mass:.1e} | {float(last['residual']):.1e} |")
    readme = pathlib.Path(__file__).resolve().parent.parent / "cases/rest/README.md"
    replace_section(readme, "rest", "\n".join(lines))


if __name__ == "__main__":
    main(sys.argv[1])
