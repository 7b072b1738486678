# What the law of friction and restitution change, on the same sites of the same piles.
# SPDX-License-Identifier: BSD-3-Clause
"""factors.py [--cores N] [--only-table]: hits every fifth site of each pile of sites.py at 500 and
2000 N with the reference engine's law of friction, without restitution, and with both; runs what is
missing, and writes factors.md and factors.csv beside this script. An hour on two cores."""
import argparse
import contextlib
import os

from sites import COLUMNS, HERE, SITES, by_pile, folder_of, hit_all, read, spread, write_rows
from remnants import commits
from table import print_table

COHESIONS = (500, 2000)  # N
PILES = range(1, 6)
LAWS = {"": ("Coulomb", "0.3", []),  # the case's own
        "-e0": ("Coulomb", "0", ["contact.restitution=0"]),
        "-convex": ("convex", "0.3", ["solver.friction=convex"]),
        "-convex-e0": ("convex", "0", ["solver.friction=convex", "contact.restitution=0"])}


def table(rows):
    own = {(row["cohesion"], row["pile"], row["site"]): row["dv"]
           for row in rows if not row["law"]}
    lines = []
    for c in COHESIONS:
        for law, (friction, restitution, _) in LAWS.items():
            some = [row for row in rows if row["cohesion"] == c and row["law"] == law]
            for row in some:
                row["change"] = row["dv"] - own[c, row["pile"], row["site"]]
            cells = []
            for key in ("dv", "change", "dv_ejecta"):
                mean, error, *_ = spread(by_pile(some, key))
                cells.append(f"{1e3 * mean:.3f} ± {1e3 * error:.3f}")
            lines.append([str(c), friction, restitution, cells[0], cells[1] if law else "",
                          cells[2]])
    print_table(["c, N", "friction", "restitution", "dv, mm/s",
                 "against the case's own laws, site by site, mm/s", "of it the ejecta, mm/s"],
                lines, 0)


def main():
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--cores", type=int, default=os.cpu_count())
    options.add_argument("--only-table", action="store_true")
    asked = options.parse_args()
    runs = [(c, pile, site, law) for c in COHESIONS for site in range(0, SITES, 5)
            for pile in PILES for law in LAWS]
    if not asked.only_table:
        hit_all(runs, asked.cores, lambda law: LAWS[law][2])
    rows = [{"law": run[3], **read(*run)} for run in runs]
    write_rows("factors.csv", ["law", *COLUMNS], rows)
    page = HERE / "factors.md"
    with open(page, "w") as file, contextlib.redirect_stdout(file):
        print("# Didymoon: friction and restitution\n"
              "Written by `cases/didymoon/factors.py`. Runs by commit "
              f"{commits([folder_of(*run) for run in runs])}, each on one rank; four sites of each "
              "of five piles.\n\n"
              "dv is along the impactor's flight, 90 s after its hit. After ± stands the standard "
              "error, with piles as clusters.\n"
              "Convex friction and no restitution are the laws of the thesis's engine.\n")
        table(rows)
    print(page.read_text())


if __name__ == "__main__":
    main()
