"""Puts the measured main job and settled step between the marks in the READMEs: write_main_job.py
RUN_FOLDER

SPDX-License-Identifier: BSD-3-Clause
"""
import csv
import pathlib
import sys
import tomllib

from readme import origin, replace_section

here = pathlib.Path(__file__).resolve().parent


def main(folder):
    with open(pathlib.Path(folder) / "results.toml", "rb") as file:
        results = tomllib.load(file)
    time = results["time"]
    stages = {key[:-2]: value for key, value in time.items()
              if key.endswith("_s") and key != "total_s"}
    shares = ", ".join(f"{stage} {100 * value / time['total_s']:.0f} %"
                       for stage, value in sorted(stages.items(), key=lambda s: -s[1]))
    with open(here / "results/settled_step.csv") as file:
        rows = list(csv.DictReader(file))
    asked = next(row for row in rows if float(row["tolerance"]) == 0.01)
    solving = float(asked["solver_s"])
    job = (f"The whole main job: **{time['total_s']:.0f} s**, {results['solver']['steps']} steps "
           f"({shares}).\n"
           f"A step of the settled pile ({float(asked['contacts']):.0f} contacts, E_eps = 1e-2, "
           f"warm): "
           f"**{1e3 * float(asked['step_s']):.0f} ms**, {1e3 * solving:.1f} ms of it solving, to "
           f"an "
           f"rms residual of {float(asked['rms_m_s']):.1e} m/s.\n"
           f"({origin(2)})")
    replace_section(here.parent / "README.md", "main job", job)
    names = ["tolerance", "products", "solver_s", "step_s", "E", "rms_m_s"]
    table = ["| tolerance on E_eps | products | solving, s | whole step, s | E | rms, m/s |",
             "|--:|--:|--:|--:|--:|--:|"]
    table += ["| " + " | ".join(row[name] for name in names) + " |" for row in rows]
    replace_section(here / "README.md", "settled step", f"{origin(2)}\n\n" + "\n".join(table))


if __name__ == "__main__":
    main(*sys.argv[1:])
