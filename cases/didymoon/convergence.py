# The table of jobs/didymoon_convergence.sh, beside the scatter of the sweep's seeds: convergence.py
# FOLDER
# SPDX-License-Identifier: BSD-3-Clause
import csv
import pathlib
import sys
import tomllib

import numpy as np

HERE = pathlib.Path(__file__).parent
NAMES = {"base": "as in case.toml: h = 0.1 ms, tolerance 1e-2, range 1 cm",
         "one-rank": "the same on one rank: another round-off",
         "step-2": "h = 0.2 ms", "step-0.5": "h = 0.05 ms", "step-0.25": "h = 0.025 ms",
         "later-0.5": "steps after the impact halved: 0.05 s, 0.5 s",
         "tolerance-1e-3": "tolerance 1e-3 during the impact",
         "tolerance-all": "tolerance 1e-3 from the impact to the end", "range-0.5": "range 0.5 cm",
         "range-2": "range 2 cm"}


def of_seeds():
    """dv at 11 and 90 s, of it the ejecta (m/s), and the bodies lost, at 500 N: a row a seed."""
    with open(HERE / "sweep.csv", newline="") as file:
        return np.array([[float(row[key])
                          for key in ("dv_11", "dv_90", "dv_ejecta", "ejecta_count")]
                         for row in csv.DictReader(file)
                         if row["law"] == "force" and float(row["cohesion"]) == 500])


def main(folder):
    lines = ["| | dv at 11 s, mm/s | dv at 90 s, mm/s | of it the ejecta | bodies lost | worst "
             "relative residual | momentum not closed |",
             "|---|--:|--:|--:|--:|--:|--:|"]
    dv90 = []
    for name, what in NAMES.items():
        path = folder / name / "results.toml"
        if not path.exists():
            continue
        with open(path, "rb") as file:
            r = tomllib.load(file)
        dv = r["read_out"]["dv"]
        dv90.append(dv[-1])
        lines.append(f"| {what} | {1e3 * dv[0]:.4g} | {1e3 * dv[-1]:.4g} | "
                     f"{1e3 * r['deflection']['dv_ejecta']:.4g} | {r['ejecta']['count']} | "
                     f"{r['solver']['residual_relative']:.2g} | "
                     f"{r['deflection']['momentum_closure']:.1e} |")
    seeds = of_seeds()
    mean, spread = seeds.mean(axis=0), np.ptp(seeds, axis=0) / 2
    lines.append(f"| mean of {len(seeds)} seeds' aggregates ± half of their range | " + " | ".join(
        f"{scale * m:.4g} ± {scale * s:.2g}"
        for m, s, scale in zip(mean, spread, (1e3, 1e3, 1e3, 1))) + " | | |")
    dv90, of_all = 1e3 * np.array(dv90), 1e3 * seeds[:, 1]
    (HERE / "convergence.md").write_text(
        "# Didymoon: what the numbers depend on\nWritten by `jobs/didymoon_convergence.sh`: 10,307 "
        "boulders, c = 500 N, all from one "
        "aggregate.\n\n" + "\n".join(lines)
        + f"\n\ndv at 90 s lies between {dv90.min():.3f} and {dv90.max():.3f} mm/s in the "
          f"{len(dv90)} runs from one "
        f"aggregate, between {of_all.min():.3f} and {of_all.max():.3f} mm/s for the {len(of_all)} "
        f"seeds.\n")


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]))
