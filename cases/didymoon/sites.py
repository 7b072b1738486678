# How much dv depends on the pile and on the place that is hit: the same impact on many sites of
# several piles.
# SPDX-License-Identifier: BSD-3-Clause
"""sites.py [--cohesions N,N,...] [--piles N] [--cores N] [--only-table]: runs what is missing in
out/didymoon-sites/, each on one rank and as many at a time as there are cores; writes sites.md,
sites.csv and sites.png beside this script. A cohesion takes an hour on two cores."""
import argparse
import concurrent.futures
import contextlib
import csv
import os
import pathlib
import sys

import matplotlib
import numpy as np

HERE = pathlib.Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent)]
from program import spall  # noqa: E402
from remnants import commits, results  # noqa: E402
from table import print_table  # noqa: E402

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

OUT = pathlib.Path("out/didymoon-sites")
SITES = 20
COLUMNS = ["cohesion", "pile", "site", "dv", "dv_ejecta", "ejecta_count", "largest_part",
           "momentum_closure", "energy_unexplained", "not_converged", "commit"]


def directions():
    """Of impactors, evenly over all: the first is the case's, others follow a golden spiral."""
    x = 1 - 2 * np.arange(SITES) / (SITES - 1)
    turn = np.pi * (3 - np.sqrt(5)) * np.arange(SITES)
    across = np.sqrt(np.maximum(0, 1 - x ** 2))
    return np.stack([x, across * np.cos(turn), across * np.sin(turn)], axis=1)


def settle(pile):
    folder = OUT / f"pile{pile}"
    if not (folder / "after_aggregation.h5").exists():
        spall("run", "cases/didymoon/case.toml", "--out", folder, "--overwrite",
              changes=[f"seed={pile}"])


def folder_of(cohesion, pile, site, law=""):
    return OUT / f"{cohesion:g}-pile{pile}-site{site}{law}"


def hit(cohesion, pile, site, direction, law="", changes=()):
    folder = folder_of(cohesion, pile, site, law)
    changes = [f"phases.impact.cohesion={cohesion:g} N",
               f"phases.impact.impactor.direction={[float(x) for x in direction]}",
               "output.snapshot_every=0", *changes]
    spall("resume", OUT / f"pile{pile}/after_aggregation.h5", "--out", folder, "--overwrite",
          changes=changes)
    print(folder, flush=True)


def hit_all(runs, cores, changes=lambda law: ()):
    """Those of [(cohesion, pile, site) or with a law] that are missing; `changes` of a law."""
    with concurrent.futures.ThreadPoolExecutor(cores) as pool:
        list(pool.map(settle, sorted({pile for _, pile, *_ in runs})))
        towards = directions()

        def run(cohesion, pile, site, law=""):
            hit(cohesion, pile, site, towards[site], law, changes(law))

        list(pool.map(lambda one: run(*one),
                      [one for one in runs if not (folder_of(*one) / "results.toml").exists()]))


def write_rows(name, columns, rows):
    with open(HERE / name, "w", newline="") as file:
        writer = csv.DictWriter(file, columns, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def read(cohesion, pile, site, law=""):
    r = results(folder_of(cohesion, pile, site, law))
    return {"cohesion": cohesion, "pile": pile, "site": site, "dv": r["deflection"]["dv"],
            "dv_ejecta": r["deflection"]["dv_ejecta"], "ejecta_count": r["ejecta"]["count"],
            "largest_part": r["clump"]["mass"] / r["pile"]["mass"],
            "momentum_closure": r["deflection"]["momentum_closure"],
            "energy_unexplained": r["conservation"]["energy_unexplained"],
            "not_converged": r["solver"]["steps_not_converged"],
            "commit": r["provenance"]["commit"]}


def by_pile(rows, key="dv"):
    return [np.array([row[key] for row in rows if row["pile"] == pile])
            for pile in sorted({row["pile"] for row in rows})]


def spread(piles):
    """Mean, its standard error with piles as clusters, standard deviation of sites on a pile,
    variance of piles: analysis of variance of one factor, by random effects."""
    means = np.array([sites.mean() for sites in piles])
    within = np.sum([np.sum((sites - sites.mean()) ** 2) for sites in piles])
    within /= sum(len(sites) - 1 for sites in piles)
    each = np.mean([len(sites) for sites in piles])
    between = means.var(ddof=1) - within / each
    return means.mean(), np.sqrt(means.var(ddof=1) / len(piles)), np.sqrt(within), between


def change(rows, c, other):
    """Of dv from cohesion `other` to `c`, by pile, each site against itself."""
    dv = {(row["cohesion"], row["pile"], row["site"]): row["dv"] for row in rows}
    return [np.array([dv[c, pile, site] - dv[other, pile, site] for site in range(SITES)])
            for pile in sorted({row["pile"] for row in rows})]


def table(rows):
    lines = []
    cohesions = sorted({row["cohesion"] for row in rows})
    for c in cohesions:
        some = [row for row in rows if row["cohesion"] == c]
        piles = by_pile(some)
        mean, error, sites, between = spread(piles)
        ejecta, ejecta_error, *_ = spread(by_pile(some, "dv_ejecta"))
        lost = [row["ejecta_count"] for row in some]
        dv = 1e3 * np.concatenate(piles)
        # A variance below nothing: less than the sites' scatter can tell from none.
        of_piles = f"{1e3 * np.sqrt(between):.3f}" if between > 0 else "none seen"
        by, by_error, *_ = spread(change(rows, c, cohesions[0]))
        lines.append([f"{c:g}", str(len(piles)), str(len(piles[0])),
                      f"{1e3 * mean:.3f} ± {1e3 * error:.3f}",
                      f"{1e3 * by:.3f} ± {1e3 * by_error:.3f}" if c > cohesions[0] else "",
                      f"{1e3 * ejecta:.3f} ± {1e3 * ejecta_error:.3f}", f"{1e3 * sites:.3f}",
                      of_piles, f"{dv.min():.3f}, {dv.max():.3f}", f"{min(lost)} to {max(lost)}",
                      f"{min(row['largest_part'] for row in some):.4f}"])
    print_table(["c, N", "piles", "sites on each", "dv, mm/s",
                 f"against {cohesions[0]:g} N, site by site, mm/s", "of it the ejecta, mm/s",
                 "standard deviation of sites on a pile, mm/s", "of piles, mm/s",
                 "least and most dv, mm/s", "bodies lost", "largest remnant, of the mass"],
                lines, 0)


def picture(rows, deflection):
    cohesions = sorted({row["cohesion"] for row in rows})
    figure, panel = plt.subplots(figsize=(7.5, 4.4), layout="constrained")
    for at, c in enumerate(cohesions):
        piles = by_pile([row for row in rows if row["cohesion"] == c])
        for k, sites in enumerate(piles):
            x = at + 0.13 * (k - (len(piles) - 1) / 2)
            panel.plot(np.full(len(sites), x), 1e3 * sites, ".", color="#2f6db3", alpha=0.45,
                       label="a site" if at == k == 0 else None)
            panel.plot(x, 1e3 * sites.mean(), "_", color="#1d2733", ms=12, mew=2,
                       label="mean of a pile" if at == k == 0 else None)
    for key, name in (("dv_plastic", "m v / M"), ("dv_elastic", "m v (1 + e) / M")):
        panel.axhline(1e3 * deflection[key], color="#8a94a3", ls=":", lw=1)
        panel.text(-0.45, 1e3 * deflection[key], name, fontsize=8, va="bottom", color="#5b6472")
    panel.set(xlabel="cohesion c (N), piles side by side", ylabel="dv at 90 s (mm/s)",
              xlim=(-0.5, len(cohesions) - 0.5), ylim=(1, None))
    panel.set_xticks(range(len(cohesions)), [f"{c:g}" for c in cohesions])
    panel.grid(axis="y", color="#e4e8ee")
    panel.legend(frameon=False)
    figure.savefig(HERE / "sites.png", dpi=110)


def main():
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--cohesions", default="100,200,300,400,500,1000,2000", help="N")
    options.add_argument("--piles", type=int, default=5)
    options.add_argument("--cores", type=int, default=os.cpu_count())
    options.add_argument("--only-table", action="store_true")
    asked = options.parse_args()
    runs = [(float(c), pile, site) for c in asked.cohesions.split(",")
            for site in range(SITES) for pile in range(1, asked.piles + 1)]
    if not asked.only_table:
        hit_all(runs, asked.cores)
    rows = [read(*run) for run in runs]
    write_rows("sites.csv", COLUMNS, rows)
    picture(rows, results(folder_of(*runs[0]))["deflection"])
    page = HERE / "sites.md"
    with open(page, "w") as file, contextlib.redirect_stdout(file):
        print("# Didymoon: sites and piles\n"
              "Written by `cases/didymoon/sites.py`. Runs by commit "
              f"{commits([folder_of(*run) for run in runs])}, each on one rank.\n\n"
              "dv is along the impactor's flight, 90 s after its hit. After ± stands the "
              "standard error, with piles as clusters. Deviations of sites and of piles come from "
              "an analysis of variance.\n")
        table(rows)
        print(f"\nMomentum closes to {max(row['momentum_closure'] for row in rows):.1e} of m v in "
              f"all {len(rows)} runs; energy that no entry explains is at most "
              f"{max(abs(row['energy_unexplained']) for row in rows):.1e} of the dissipated; "
              f"{sum(row['not_converged'] for row in rows)} steps did not converge.")
    print(page.read_text())


if __name__ == "__main__":
    main()
