# The sweep over cohesions and seeds: tables beside the thesis, their scatter, and a picture.
# SPDX-License-Identifier: BSD-3-Clause
"""sweep.py FOLDER: reads FOLDER/seed<s>-<c>/results.toml; writes results.md, sweep.csv and sweep.png beside this script."""
import contextlib
import csv
import io
import pathlib
import re
import subprocess
import sys
import tomllib

import matplotlib
import numpy as np

HERE = pathlib.Path(__file__).parent
sys.path.insert(0, str(HERE))
import table  # noqa: E402

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

TIMES = (11, 51, 68, 90)
COLUMNS = ["cohesion", "seed", *(f"dv_{t}" for t in TIMES), "dv_impactor", "dv_rebound", "dv_ejecta", "beta", "clump_count",
           "ejecta_count", "ejecta_mass", "v_ejecta", "T_new_min", "momentum_closure", "linear", "angular", "energy_unexplained"]


def read(path):
    with open(path, "rb") as file:
        r = tomllib.load(file)
    seed, cohesion = re.fullmatch(r"seed(\d+)-([\d.]+)", path.parent.name).groups()
    row = {"cohesion": float(cohesion), "seed": int(seed)}
    row |= {f"dv_{t}": table.look_up(r, f"read_out.dv[{t}]") for t in TIMES}
    row |= {key: r["deflection"][key] for key in ("dv_impactor", "dv_rebound", "dv_ejecta", "beta", "T_new_min", "momentum_closure")}
    row |= {"clump_count": r["clump"]["count"], "ejecta_count": r["ejecta"]["count"], "ejecta_mass": r["ejecta"]["mass"],
            "v_ejecta": r["ejecta"]["v_ejecta"]}
    return row | {key: r["conservation"][key] for key in ("linear", "angular", "energy_unexplained")}, r["deflection"]


def of_thesis(key):
    """The printed values of a row of thesis.toml, by cohesion."""
    with open(HERE / "thesis.toml", "rb") as file:
        rows = tomllib.load(file)["row"]
    return {row["when"]["cohesion"]: row["printed"] for row in rows if row["key"] == key and "when" in row}


def text(values, scale=1.0):
    """Mean and the half of the range over seeds."""
    values = np.array(values) * scale
    spread = f" ± {np.ptp(values) / 2:.2g}" if len(values) > 1 else ""
    return f"{values.mean():.4g}{spread}"


def sweep_table(rows, deflection):
    dv, v_ejecta = of_thesis("deflection.dv"), of_thesis("ejecta.v_ejecta")
    print("## The sweep\n")
    print(f"Mean over the seeds' aggregates, ± half of their range. Without ejecta dv is {1e3 * deflection['dv_plastic']:.4g} mm/s for an "
          f"impactor that sticks, {1e3 * deflection['dv_elastic']:.4g} mm/s for one that rebounds.\n")
    heading = ["c, N", "seeds", *(f"dv at {t} s, mm/s" for t in TIMES), "thesis", "of it the ejecta, mm/s", "bodies lost",
               "v_ejecta, m/s", "thesis", "momentum not closed, of m v"]
    lines = []
    for c in sorted({row["cohesion"] for row in rows}):
        some = [row for row in rows if row["cohesion"] == c]
        lines.append([f"{c:g}", str(len(some)), *(text([row[f"dv_{t}"] for row in some], 1e3) for t in TIMES),
                      f"{1e3 * dv[c]:.4g}" if c in dv else "", text([row["dv_ejecta"] for row in some], 1e3),
                      text([row["ejecta_count"] for row in some]), text([row["v_ejecta"] for row in some]),
                      f"{v_ejecta[c]:.4g}" if c in v_ejecta else "", f"{max(row['momentum_closure'] for row in some):.1e}"])
    table.print_table(heading, lines, 0)
    print()


def picture(rows, deflection):
    figure, (left, right) = plt.subplots(1, 2, figsize=(12, 4.4), layout="constrained")
    for panel, key, thesis, name, scale in ((left, "dv_90", of_thesis("deflection.dv"), "dv at 90 s (mm/s)", 1e3),
                                            (right, "v_ejecta", of_thesis("ejecta.v_ejecta"), "v_ejecta (m/s)", 1)):
        for seed, color in zip(sorted({row["seed"] for row in rows}), ("#2f6db3", "#3f8f5b", "#7a5ea8")):
            some = sorted((row["cohesion"], row[key] * scale) for row in rows if row["seed"] == seed)
            panel.plot(*zip(*some), "o-", color=color, label=f"Spall, seed {seed}")
        if thesis:
            panel.plot(*zip(*sorted((c, v * scale) for c, v in thesis.items())), "s--", color="#d9822b", label="thesis, as printed")
        panel.set(xscale="log", xlabel="cohesion c (N)", ylabel=name, ylim=(0, None))
        panel.grid(color="#e4e8ee")
    for value, name in ((deflection["dv_plastic"], "m v / M"), (deflection["dv_elastic"], "m v (1 + e) / M")):
        left.axhline(1e3 * value, color="#8a94a3", ls=":", lw=1)
        left.text(100, 1e3 * value, name, fontsize=8, va="bottom", color="#5b6472")
    right.legend(frameon=False)
    figure.savefig(HERE / "sweep.png", dpi=110)


def main(folder):
    paths = sorted(pathlib.Path(folder).glob("seed*/results.toml"))
    runs = [read(path) for path in paths]
    rows = sorted((row for row, _ in runs), key=lambda row: (row["cohesion"], row["seed"]))
    with open(HERE / "sweep.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    picture(rows, runs[0][1])
    text_of_tables = io.StringIO()
    with contextlib.redirect_stdout(text_of_tables):
        sweep_table(rows, runs[0][1])
        table.main([str(path.parent) for path in paths if path.parent.name.startswith("seed1-")])
    commit = subprocess.run(["git", "describe", "--always", "--dirty"], capture_output=True, text=True, check=False).stdout.strip()
    (HERE / "results.md").write_text("# Didymoon: the impacts, beside the thesis\n"
                                     f"Written by `jobs/didymoon_sweep.sh`, drawn at commit {commit}; the tables after the first are seed 1.\n\n"
                                     + text_of_tables.getvalue())


if __name__ == "__main__":
    main(sys.argv[1])
