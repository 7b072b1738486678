# DART at several resolutions, each beside the observations; how much is ejected how fast.
# SPDX-License-Identifier: BSD-3-Clause
"""run.py [--only-table]: runs what is missing in out/, writes results.md, ejecta.png and bodies.png beside this script."""
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
from table import print_table, text  # noqa: E402, F401
from report_reference import look_up  # noqa: E402

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

RESOLUTIONS = ("2", "1")  # m: the largest radius at the site
ROWS = [("bodies", None, ""), ("smallest radius", None, "m"), ("dv", "deflection.dv", "m/s"), ("beta, vector formula", "deflection.beta", ""),
        ("beta along the flight", "deflection.beta_along", ""), ("change of the period", "deflection.dT_min", "min"),
        ("ejecta", "ejecta.count", ""), ("their mass", "ejecta.mass", "kg"), ("the fastest", "ejecta.fastest", "m/s"),
        ("half-aperture with half of their momentum (sum of sizes)", "ejecta.cone_half_deg", "deg"), ("with 90 % of it", "ejecta.cone_most_deg", "deg"),
        ("mass of the pile", "pile.mass", "kg"), ("its axes", "pile.axes", "m"), ("momentum not closed, of m v", "deflection.momentum_closure", ""),
        ("drift of momentum, of m v", "conservation.linear", ""), ("energy unexplained, of the dissipated", "conservation.energy_unexplained", "")]


def observed():
    with open(HERE / "reference.toml", "rb") as file:
        return {row["key"]: (row["printed"], row.get("note", "")) for row in tomllib.load(file)["row"]}


def show(value):
    if isinstance(value, list):
        return (", " if len(value) == 3 else " to ").join(show(one) for one in value)
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def ejecta(folder):
    """Speeds (m/s) of the ejecta relative to the remnant, fastest first, and the mass that is at least as fast (kg)."""
    with h5py.File(folder / "trajectory.h5") as file:
        impactor = len(file["particles/all/radius"]) - 1
    position, velocity, radius, mass = (x[:impactor] for x in last_frame(folder))
    inside = largest_remnant(position, velocity, radius, mass)
    speed = np.linalg.norm(velocity[~inside] - np.average(velocity[inside], axis=0, weights=mass[inside]), axis=1)
    order = np.argsort(-speed)
    return speed[order], np.cumsum(mass[~inside][order])


def main():
    folders = {r: pathlib.Path(f"out/dart-{r}") for r in RESOLUTIONS}
    for r, folder in folders.items():
        if "--only-table" not in sys.argv and not (folder / "results.toml").exists():
            subprocess.run(["mpirun", "-n", "2", "build/release/spall", "run", "cases/dart/case.toml", "--out", str(folder), "--set",
                            f"groups.dimorphos.packing.smallest={r} m"], check=True)
    folders = {r: folder for r, folder in folders.items() if (folder / "results.toml").exists()}
    runs = {r: results(folder) for r, folder in folders.items()}
    reference = observed()
    lines = []
    for name, key, unit in ROWS:
        if key is None:
            radii = [last_frame(folder)[2][:-1] for folder in folders.values()]
            values = [str(len(x)) if name == "bodies" else f"{x.min():.3g}" for x in radii]
        else:
            values = [show(look_up(run, key)) for run in runs.values()]
        printed, note = reference.get(key, ("", ""))
        lines.append("| " + " | ".join([name, unit, show(printed), *values, note]) + " |")
    heading = ["", "", "observed", *(f"{r} m at the site" for r in runs), "note"]
    reads = [f"| {r} m | " + " | ".join(f"{dv:.4g}" for dv in run["read_out"]["dv"]) + " | "
             + " | ".join(f"{b:.4g}" for b in run["read_out"]["beta"]) + " |" for r, run in runs.items()]
    at = [f"{t:.3g} s" for t in next(iter(runs.values()))["read_out"]["since_impact"]]
    (HERE / "results.md").write_text(
        "# DART: the runs beside the observations\nWritten by `cases/dart/run.py`; at the last read-out unless said otherwise.\n\n"
        "| " + " | ".join(heading) + " |\n|---|---|" + "--:|" * (len(runs) + 1) + "---|\n" + "\n".join(lines)
        + "\n\n## In time\n\n| | " + " | ".join(f"dv at {t}, m/s" for t in at) + " | " + " | ".join(f"beta at {t}" for t in at)
        + " |\n|---|" + "--:|" * (2 * len(at)) + "\n" + "\n".join(reads) + "\n")

    figure, panel = plt.subplots(figsize=(8, 4.4), layout="constrained")
    for (r, folder), color in zip(folders.items(), ("#8a94a3", "#3f8f5b", "#2f6db3")):
        panel.plot(*ejecta(folder), drawstyle="steps-post", color=color, label=f"{r} m at the site")
    panel.axhspan(*reference["ejecta.mass"][0], color="#d9822b", alpha=0.25, lw=0, label="all ejecta, observed (Ferrari et al. 2025)")
    panel.set(xscale="log", yscale="log", xlabel="speed v relative to what is left (m/s)", ylabel="mass ejected faster than v (kg)")
    panel.grid(color="#e4e8ee")
    panel.legend(frameon=False)
    figure.savefig(HERE / "ejecta.png", dpi=110)
    finest = folders[list(folders)[-1]]
    subprocess.run(["build/release/spall", "report", str(finest)], check=True)
    shutil.copy(finest / "report/bodies.png", HERE / "bodies.png")


if __name__ == "__main__":
    main()
