# Two piles at several speeds: the largest remnant beside Leinhardt & Stewart 2012.
# SPDX-License-Identifier: BSD-3-Clause
"""run.py [--only-table]: runs what is missing in out/, writes results.md and remnants.png beside this script."""
import pathlib
import subprocess
import sys

import h5py
import matplotlib
import numpy as np

HERE = pathlib.Path(__file__).parent
sys.path.insert(0, str(HERE.parent))
from remnants import G, largest_remnant, last_frame, results  # noqa: E402

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

SPEEDS = (0.03, 0.1, 0.2, 0.3, 0.45, 0.6)


def catastrophic_energy(target, projectile, c_star, mu=0.37):
    """J/kg: half of the mass is dispersed. Leinhardt & Stewart 2012 (ApJ 745:79), eqs. 28, 23: the principal curve
    c* 4/5 pi rho1 G R_C1^2 with R_C1 the radius of all mass at rho1 = 1000 kg/m^3, and the mass ratio's factor."""
    rho1 = 1000.0
    radius = (3 * (target + projectile) / (4 * np.pi * rho1)) ** (1 / 3)
    ratio = projectile / target
    return c_star * 0.8 * np.pi * rho1 * G * radius**2 * ((ratio + 1) ** 2 / (4 * ratio)) ** (2 / (3 * mu) - 1)


def read(speed):
    folder = pathlib.Path(f"out/merge-{speed}")
    position, velocity, radius, mass = last_frame(folder)
    with h5py.File(folder / "trajectory.h5") as file:
        group = file["particles/all/group"][:]
    target, projectile = mass[group == 0].sum(), mass[group == 1].sum()
    inside = largest_remnant(position, velocity, radius, mass)
    reduced = target * projectile / (target + projectile)
    return {"speed": speed, "Q": reduced * speed**2 / 2 / mass.sum(), "remnant": mass[inside].sum() / mass.sum(),
            "left": int((~inside).sum()), "target": target, "projectile": projectile,
            "drift": results(folder)["conservation"]["linear"]}


def main():
    if "--only-table" not in sys.argv:
        for speed in SPEEDS:
            if not pathlib.Path(f"out/merge-{speed}/results.toml").exists():
                subprocess.run(["mpirun", "-n", "2", "build/release/spall", "run", "cases/merge/case.toml", "--out",
                                f"out/merge-{speed}", "--set", f"groups.projectile.velocity=[{speed}, 0, 0]"], check=True)
    rows = [read(speed) for speed in SPEEDS]
    target, projectile = rows[0]["target"], rows[0]["projectile"]
    curves = {c: catastrophic_energy(target, projectile, c) for c in (3, 5, 7)}
    lines = ["# Two piles meet head-on: the runs", "Written by `cases/merge/run.py`.", "",
             f"Target {target:.4g} kg, projectile {projectile:.4g} kg; Q*: {curves[3]:.3g}, {curves[5]:.3g}, {curves[7]:.3g} J/kg "
             "for c* = 3, 5, 7.", "",
             "| speed at 120 m, m/s | Q_R, J/kg | Q_R / Q* (c* = 5) | largest remnant | 1 - Q_R / 2 Q* (c* = 3, 5, 7) | bodies lost | "
             "drift of momentum |", "|--:|--:|--:|--:|--:|--:|--:|"]
    for row in rows:
        law = ", ".join(f"{max(1 - row['Q'] / 2 / q, 0):.2f}" for q in curves.values())
        lines.append(f"| {row['speed']} | {row['Q']:.3g} | {row['Q'] / curves[5]:.3g} | {row['remnant']:.3f} | {law} | {row['left']} | "
                     f"{row['drift']:.1e} |")
    (HERE / "results.md").write_text("\n".join(lines) + "\n")

    figure, panel = plt.subplots(figsize=(8, 4.2), layout="constrained")
    x = np.linspace(0, 1.3 * max(row["Q"] for row in rows) / curves[5], 100)
    panel.fill_between(x, np.clip(1 - x / 2 * 5 / 3, 0, 1), np.clip(1 - x / 2 * 5 / 7, 0, 1), color="#d9822b", alpha=0.2, lw=0,
                       label="Leinhardt & Stewart 2012, c* = 5 ± 2")
    panel.plot(x, np.clip(1 - x / 2, 0, 1), color="#d9822b")
    panel.plot([row["Q"] / curves[5] for row in rows], [row["remnant"] for row in rows], "o", color="#2f6db3", label="Spall")
    panel.set(xlabel="Q_R / Q*", ylabel="largest remnant, of all mass", ylim=(0, 1.03))
    panel.legend(frameon=False)
    panel.grid(color="#e4e8ee")
    figure.savefig(HERE / "remnants.png", dpi=110)


if __name__ == "__main__":
    main()
