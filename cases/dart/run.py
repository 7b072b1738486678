# DART at several resolutions and densities, each beside the observations; how much is ejected how
# fast.
# SPDX-License-Identifier: BSD-3-Clause
"""run.py [--only-table]: runs what is missing in out/, writes results.md, ejecta.png and bodies.png
beside this script."""
import pathlib
import shutil
import subprocess
import sys
import tomllib

import h5py
import matplotlib
import numpy as np

HERE = pathlib.Path(__file__).parent
sys.path[:0] = [str(HERE.parent), str(HERE.parent / "didymoon")]
from remnants import largest_remnant, last_frame, results  # noqa: E402
from table import look_up  # noqa: E402

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

RESOLUTIONS = (2.0, 1.0, 0.5)  # m: the largest radius at the site
SEEDS = (1, 2, 3)
DENSITY, ERROR, VOLUME = 1540, 220, 2.78e9 / 1540  # kg/m^3 (Makadia et al. 2026), m^3
DENSITIES = (DENSITY - ERROR, DENSITY, DENSITY + ERROR)  # the outer ones at 1 m alone
COHESION = 0.44  # N at 1 m: 2 Pa by Rumpf's formula, as the square of the size
SPEEDS = (0.1, 0.3, 1, 3, 10)  # m/s
ROWS = [("bodies", None, ""), ("smallest radius", None, "m"), ("dv", "deflection.dv", "m/s"),
        ("beta, vector formula", "deflection.beta", ""),
        ("beta along the flight", "deflection.beta_along", ""),
        ("change of the period", "deflection.dT_min", "min"),
        ("ejecta", "ejecta.count", ""), ("their mass", "ejecta.mass", "kg"),
        ("the fastest", "ejecta.fastest", "m/s"),
        ("half-aperture with half of their momentum (sum of sizes)", "ejecta.cone_half_deg", "deg"),
        ("with 90 % of it", "ejecta.cone_most_deg", "deg"),
        ("mass of the pile", "pile.mass", "kg"), ("its axes", "pile.axes", "m"),
        ("density of a boulder", None, "kg/m^3"),
        ("mass of the struck boulder", "deflection.struck_mass", "kg"),
        ("rigid share of the energy", "deflection.rigid_share", ""),
        ("momentum not closed, of m v (worst)", "deflection.momentum_closure", ""),
        ("drift of momentum, of m v (worst)", "conservation.linear", ""),
        ("energy unexplained, of the dissipated (worst)", "conservation.energy_unexplained", "")]


def observed():
    with open(HERE / "reference.toml", "rb") as file:
        return {row["key"]: (row["printed"], row.get("note", ""))
                for row in tomllib.load(file)["row"]}


def show(value):
    if isinstance(value, list):
        return (", " if len(value) == 3 else " to ").join(show(one) for one in value)
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def scatter(values):
    """Mean ± half of the range over seeds."""
    values = np.array(values, dtype=float)
    spread = f" ± {np.ptp(values) / 2:.2g}" if np.ptp(values) > 1e-9 * np.max(
        np.abs(values)) else ""
    return f"{values.mean():.4g}{spread}"


def row_of(name, key, runs):
    """A cell of the table: runs of all seeds at one resolution and density, as (folder,
    results)."""
    if name == "bodies":
        return scatter([len(last_frame(folder)[2]) - 1 for folder, _ in runs])
    if name == "smallest radius":
        return f"{min(last_frame(folder)[2][:-1].min() for folder, _ in runs):.3g}"
    if key is None:
        _, _, radius, mass = last_frame(runs[0][0])
        return f"{mass[0] / (4 / 3 * np.pi * radius[0]**3):.4g}"
    values = [look_up(run, key) for _, run in runs]
    if name.endswith("(worst)"):
        return f"{max(map(abs, values)):.1e}"
    return ", ".join(map(scatter, zip(*values))) if isinstance(values[0], list) else scatter(values)


def ejecta(folder):
    """Speeds (m/s) of the ejecta relative to the remnant, fastest first, and the mass that is at
    least as fast (kg)."""
    with h5py.File(folder / "trajectory.h5") as file:
        impactor = len(file["particles/all/radius"]) - 1
    position, velocity, radius, mass = (x[:impactor] for x in last_frame(folder))
    inside = largest_remnant(position, velocity, radius, mass)
    speed = np.linalg.norm(velocity[~inside]
                           - np.average(velocity[inside], axis=0, weights=mass[inside]), axis=1)
    order = np.argsort(-speed)
    return speed[order], np.cumsum(mass[~inside][order])


def main():
    outer = [(1.0, density) for density in DENSITIES if density != DENSITY]
    folders = {(r, density, seed): pathlib.Path(f"out/dart-{density}-{r:g}-{seed}")
               for seed in SEEDS for r, density in [*((r, DENSITY) for r in RESOLUTIONS), *outer]}
    for (r, density, seed), folder in folders.items():
        if "--only-table" not in sys.argv and not (folder / "results.toml").exists():
            subprocess.run(["mpirun", "-n", "2", "build/release/spall", "run",
                            "cases/dart/case.toml", "--out", str(folder), "--overwrite",
                            "--set", f"seed={seed}", "--set",
                            f"groups.dimorphos.total_mass={density * VOLUME} kg",
                            "--set", f"groups.dimorphos.packing.smallest={r} m", "--set",
                            f"phases.impact.cohesion={COHESION * r**2} N"], check=True)
    there = {key: (folder, results(folder))
             for key, folder in sorted(folders.items(),
                                       key=lambda item: (-item[0][0], *item[0][1:]))
             if (folder / "results.toml").exists()}

    def runs_at(r, density):
        return [run for key, run in there.items() if key[:2] == (r, density)]
    columns = [(r, DENSITY) for r in RESOLUTIONS if runs_at(r, DENSITY)]
    reference = observed()
    lines = []
    for name, key, unit in ROWS:
        printed, note = reference.get(key, ("", ""))
        lines.append("| "
                     + " | ".join([name, unit, show(printed),
                                   *(row_of(name, key, runs_at(*at)) for at in columns), note])
                     + " |")
    heading = ["", "", "observed", *(f"{r:g} m at the site" for r, _ in columns), "note"]
    lighter = ("dv", "beta, vector formula", "change of the period", "their mass",
               "density of a boulder", "rigid share of the energy")
    by_density = ["| "
                  + " | ".join([name, unit,
                                *(row_of(name, key, runs_at(1.0, density)) for density in DENSITIES
                                  if runs_at(1.0, density))]) + " |"
                  for name, key, unit in ROWS if name in lighter]
    first = next(iter(there.values()))[1]
    at = [f"{t:.3g} s" for t in first["read_out"]["since_impact"]]
    reads = [f"| {r:g} m | {density} | {seed} | {run['case']['cohesion']:.3g} | "
             + " | ".join(f"{1e3 * dv:.4g}" for dv in run["read_out"]["dv"]) + " | "
             + " | ".join(f"{b:.4g}" for b in run["read_out"]["beta"]) + " | "
             + show(run["deflection"]["struck_mass"]) + " | "
             + show(run["deflection"]["rigid_share"]) + " |"
             for (r, density, seed), (_, run) in there.items()]
    plume = {key: ejecta(folder) for key, (folder, _) in there.items() if key[1] == DENSITY}

    def faster(key, v):
        speed, mass = plume[key]
        return mass[np.sum(speed >= v) - 1] if np.any(speed >= v) else 0.0
    masses = ["| "
              + " | ".join([f"{v:g} m/s",
                            *(scatter([faster(key, v) for key in plume if key[:2] == at])
                              for at in columns)]) + " |" for v in SPEEDS]
    (HERE / "results.md").write_text(
        f"# DART: the runs beside the observations\nWritten by `cases/dart/run.py`, by commit "
        f"{first['provenance']['commit']}; at the last read-out unless said "
        f"otherwise; mean over the seeds ± half of their range ({len(SEEDS)} seeds). Dimorphos has "
        f"{DENSITY} kg/m^3.\n\n"
        "| " + " | ".join(heading) + " |\n|---|---|" + "--:|" * (len(columns) + 1) + "---|\n"
        + "\n".join(lines)
        + "\n\n## By density, 1 m at the site\n\n| | | "
        + " | ".join(f"{density} kg/m^3" for density in DENSITIES if runs_at(1.0, density))
        + " |\n|---|---|"
        + "--:|" * sum(bool(runs_at(1.0, density)) for density in DENSITIES) + "\n"
        + "\n".join(by_density)
        + "\n\n## Mass ejected faster than v, kg\n\n| | "
        + " | ".join(f"{r:g} m at the site" for r, _ in columns) + " |\n|---|" + "--:|"
        * len(columns) + "\n"
        + "\n".join(masses) + "\n\n## In time\n\n| | kg/m^3 | seed | cohesion, N | "
        + " | ".join(f"dv at {t}, mm/s" for t in at) + " | "
        + " | ".join(f"beta at {t}" for t in at)
        + " | struck boulder, kg | rigid share |\n|---|--:|--:|--:|" + "--:|" * (2 * len(at) + 2)
        + "\n" + "\n".join(reads) + "\n")

    figure, panel = plt.subplots(figsize=(8, 4.4), layout="constrained")
    colors = dict(zip(RESOLUTIONS, ("#8a94a3", "#3f8f5b", "#2f6db3")))
    for (r, _, seed), curve in plume.items():
        panel.plot(*curve, drawstyle="steps-post", color=colors[r],
                   label=f"{r:g} m at the site" if seed == SEEDS[0] else None)
    panel.axhspan(*reference["ejecta.mass"][0], color="#d9822b", alpha=0.25, lw=0,
                  label="all ejecta, observed (Ferrari et al. 2025)")
    panel.set(xscale="log", yscale="log", xlabel="speed v relative to what is left (m/s)",
              ylabel="mass ejected faster than v (kg)")
    panel.grid(color="#e4e8ee")
    panel.legend(frameon=False)
    figure.savefig(HERE / "ejecta.png", dpi=110)
    finest = [folder for (_, _, seed), (folder, _) in there.items() if seed == SEEDS[0]][-1]
    subprocess.run(["build/release/spall", "report", str(finest)], check=True)
    shutil.copy(finest / "report/bodies.png", HERE / "bodies.png")


if __name__ == "__main__":
    main()
