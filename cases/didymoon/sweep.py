# The sweep over cohesions, seeds and the two readings of cohesion: tables beside the thesis, their
# scatter, and a picture.
# SPDX-License-Identifier: BSD-3-Clause
"""sweep.py FOLDER: reads FOLDER/<law>-seed<s>-<c>/results.toml; writes results.md, sweep.csv and
sweep.png beside this script."""
import contextlib
import csv
import io
import pathlib
import re
import sys
import tomllib

import h5py
import matplotlib
import numpy as np

HERE = pathlib.Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent)]
import table  # noqa: E402
from remnants import commits  # noqa: E402

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

TIMES = (11, 51, 68, 90)
LAWS = {"force": "c as a force", "impulse": "c as an impulse a step"}
COLUMNS = ["law", "cohesion", "seed", *(f"dv_{t}" for t in TIMES), "dv_impactor", "dv_rebound",
           "dv_ejecta", "beta", "clump_count",
           "clump_part", "ejecta_count", "ejecta_mass", "v_ejecta", "T_new_min", "momentum_closure",
           "linear", "angular",
           "energy_unexplained", "residual_relative", "seconds"]


def seconds_before(pile):
    """What a run had taken when its aggregate was stored: resumed runs count it in."""
    with h5py.File(pile / "after_aggregation.h5") as file:
        names = file["scalars/names"][()].decode().split("\n")
        return file["scalars/values"][names.index("run.seconds")]


def read(path):
    with open(path, "rb") as file:
        r = tomllib.load(file)
    law, seed, cohesion = re.fullmatch(r"(\w+)-seed(\d+)-([\d.]+)", path.parent.name).groups()
    row = {"law": law, "cohesion": float(cohesion), "seed": int(seed)}
    row |= {f"dv_{t}": table.look_up(r, f"read_out.dv[{t}]") for t in TIMES}
    row |= {key: r["deflection"][key]
            for key in ("dv_impactor", "dv_rebound", "dv_ejecta", "beta", "T_new_min",
                        "momentum_closure")}
    row |= {"clump_count": r["clump"]["count"],
            "clump_part": r["clump"]["mass"] / r["pile"]["mass"],
            "ejecta_count": r["ejecta"]["count"],
            "ejecta_mass": r["ejecta"]["mass"], "v_ejecta": r["ejecta"]["v_ejecta"],
            "residual_relative": r["solver"]["residual_relative"],
            "seconds": r["time"]["total_s"] - seconds_before(path.parents[1] / f"pile{seed}")}
    return row | {key: r["conservation"][key]
                  for key in ("linear", "angular", "energy_unexplained")}, r["deflection"]


def of_thesis(key):
    """The printed values of a row of thesis.toml, by cohesion."""
    with open(HERE / "thesis.toml", "rb") as file:
        rows = tomllib.load(file)["row"]
    return {row["when"]["cohesion"]: row["printed"] for row in rows if row["key"] == key
            and "when" in row}


def text(values, scale=1.0):
    """Mean and the half of the range over seeds."""
    values = np.array(values) * scale
    spread = f" ± {np.ptp(values) / 2:.2g}" if len(values) > 1 else ""
    return f"{values.mean():.4g}{spread}"


def cohesions(rows):
    return sorted({row["cohesion"] for row in rows})


def sweep_table(rows):
    dv, v_ejecta = of_thesis("deflection.dv"), of_thesis("ejecta.v_ejecta")
    heading = ["c, N", "seeds", *(f"dv at {t} s, mm/s" for t in TIMES), "thesis",
               "of it the ejecta, mm/s", "bodies lost",
               "v_ejecta, m/s", "thesis", "largest remnant, of the mass",
               "momentum not closed, of m v"]
    lines = []
    for c in cohesions(rows):
        some = [row for row in rows if row["cohesion"] == c]
        lines.append([f"{c:g}", str(len(some)),
                      *(text([row[f"dv_{t}"] for row in some], 1e3) for t in TIMES),
                      f"{1e3 * dv[c]:.4g}" if c in dv else "",
                      text([row["dv_ejecta"] for row in some], 1e3),
                      text([row["ejecta_count"] for row in some]),
                      text([row["v_ejecta"] for row in some]),
                      f"{v_ejecta[c]:.4g}" if c in v_ejecta else "",
                      f"{min(row['clump_part'] for row in some):.4f}",
                      f"{max(row['momentum_closure'] for row in some):.1e}"])
    table.print_table(heading, lines, 0)


def trend_table(rows):
    """Of each seed's dv(c): where it peaks, how it falls, how much of it is scatter."""
    lines = []
    for law in LAWS:
        for t in TIMES:
            peaks, slopes, rises, lost = [], [], [], []
            for seed in sorted({row["seed"] for row in rows if row["law"] == law}):
                one = sorted((row["cohesion"], row[f"dv_{t}"] * 1e3) for row in rows
                             if row["law"] == law and row["seed"] == seed)
                c, dv = np.array(one).T
                peaks.append(f"{c[np.argmax(dv)]:g}")
                rises.append(f"{np.sum(np.diff(dv) > 0)} of {len(c) - 1}")
                slope, offset = np.polyfit(np.log10(c), dv, 1) if len(c) > 1 else (np.nan, np.nan)
                slopes.append(slope)
                lost.append(np.std(dv - offset - slope * np.log10(c)))
            if slopes:
                lines.append([LAWS[law], f"{t} s", ", ".join(peaks),
                              ", ".join(f"{s:.3f}" for s in slopes), ", ".join(rises),
                              ", ".join(f"{s:.3f}" for s in lost)])
    table.print_table(["c read as", "read at", "c of the largest dv, N",
                       "change of dv over a decade of c, mm/s",
                       "steps in c at which dv rises", "scatter about that line, mm/s"], lines, 2)


def picture(rows, deflection):
    figure, panels = plt.subplots(1, 3, figsize=(15, 4.4), layout="constrained")
    of = {law: [row for row in rows if row["law"] == law] for law in LAWS}
    for panel, key, law, thesis, name, scale in (
            (panels[0], "dv_90", "force", of_thesis("deflection.dv"),
             "dv at 90 s (mm/s), c as a force", 1e3),
            (panels[1], "dv_90", "impulse", of_thesis("deflection.dv"),
             "dv at 90 s (mm/s), c as an impulse a step", 1e3),
            (panels[2], "v_ejecta", "force", of_thesis("ejecta.v_ejecta"),
             "v_ejecta (m/s), c as a force", 1)):
        for seed, color in zip(sorted({row["seed"] for row in of[law]}),
                               ("#2f6db3", "#3f8f5b", "#7a5ea8")):
            some = sorted((row["cohesion"], row[key] * scale) for row in of[law]
                          if row["seed"] == seed)
            panel.plot(*zip(*some), "o-", color=color, label=f"Spall, seed {seed}")
        if thesis:
            panel.plot(*zip(*sorted((c, v * scale) for c, v in thesis.items())), "s--",
                       color="#d9822b", label="thesis, as printed")
        panel.set(xscale="log",
                  xlabel="cohesion c (N, N s)" if law == "impulse" else "cohesion c (N)",
                  ylabel=name, ylim=(0, None))
        panel.grid(color="#e4e8ee")
    for panel in panels[:2]:
        panel.set_ylim(0, 1.05e3 * max(row["dv_90"] for row in rows))
        for value, name in ((deflection["dv_plastic"], "m v / M"),
                            (deflection["dv_elastic"], "m v (1 + e) / M")):
            panel.axhline(1e3 * value, color="#8a94a3", ls=":", lw=1)
            panel.text(100, 1e3 * value, name, fontsize=8, va="bottom", color="#5b6472")
    panels[2].legend(frameon=False)
    figure.savefig(HERE / "sweep.png", dpi=110)


def summary(rows, folder, deflection):
    piles = [path.parent for path in pathlib.Path(folder).glob("pile*/after_aggregation.h5")]
    forces = [row for row in rows if row["law"] == "force"]
    whole = min(row["clump_part"] for row in rows)
    print(f"Time: {len(piles)} aggregates {sum(map(seconds_before, piles)):.0f} s; {len(forces)} "
          f"impacts with c as a force "
          f"{sum(row['seconds'] for row in forces):.0f} s, {len(rows) - len(forces)} with c as an "
          f"impulse "
          f"{sum(row['seconds'] for row in rows if row['law'] == 'impulse'):.0f} s.\n")
    print(f"Over all runs: linear momentum kept to {max(row['linear'] for row in rows):.1e} of m "
          f"v, angular to "
          f"{max(row['angular'] for row in rows):.1e}, energy that no entry explains at most "
          f"{max(abs(row['energy_unexplained']) for row in rows):.1e} of the dissipated; the "
          f"smallest remnant holds {whole:.4f} of the mass: "
          + ("no cohesion shatters the pile.\n" if whole > 0.5 else "the pile is shattered.\n"))
    print(f"In the tables: mean over the seeds' aggregates, ± half of their range. Without ejecta "
          f"dv is {1e3 * deflection['dv_plastic']:.4g} "
          f"mm/s for an impactor that sticks, {1e3 * deflection['dv_elastic']:.4g} mm/s for one "
          f"that rebounds.\n")


def main(folder):
    paths = sorted(pathlib.Path(folder).glob("*-seed*/results.toml"))
    runs = [read(path) for path in paths]
    rows = sorted((row for row, _ in runs),
                  key=lambda row: (row["law"], row["cohesion"], row["seed"]))
    with open(HERE / "sweep.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    picture(rows, runs[0][1])
    text_of_tables = io.StringIO()
    with contextlib.redirect_stdout(text_of_tables):
        summary(rows, folder, runs[0][1])
        print("## Cohesion as a force with a range\n")
        sweep_table([row for row in rows if row["law"] == "force"])
        print("\n## Cohesion as the thesis's engine reads it: the bound of an impulse in each "
              "step\n\nc N s a step: 5 MN at the "
              "impact's 0.1 ms for c = 500, 500 N at the evolution's 1 s.\n")
        sweep_table([row for row in rows if row["law"] == "impulse"])
        print("\n## The trend with c at fixed times\n\nOne figure a seed.\n")
        trend_table(rows)
        print()
        table.main(
            [str(path.parent) for path in paths if path.parent.name.startswith("force-seed1-")])
    (HERE / "results.md").write_text("# Didymoon: the impacts, beside the thesis\n"
                                     "Written by `jobs/didymoon_sweep.sh`. Runs by commit "
                                     f"{commits([path.parent for path in paths])}; the tables of "
                                     "single runs are seed 1.\n\n"
                                     + text_of_tables.getvalue())


if __name__ == "__main__":
    main(sys.argv[1])
