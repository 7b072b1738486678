# Two piles at several speeds: the largest remnant beside Leinhardt & Stewart 2012.
# SPDX-License-Identifier: BSD-3-Clause
"""run.py [--only-table]: runs what is missing in out/, writes results.md and remnants.png beside
this script."""
import pathlib
import sys

import h5py
import matplotlib
import numpy as np

HERE = pathlib.Path(__file__).parent
sys.path.insert(0, str(HERE.parent))
from remnants import (SEEDS, G, commits, largest_remnant, last_frame, pile,  # noqa: E402
                      results, run_all, scatter)

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

PROJECTILE = "groups.projectile"
SMOOTH = ["contact.friction=0", "contact.restitution=0.5"]
WHOLE = [f"{PROJECTILE}.volume="
         '{shape = "sphere", radius = "1 km", center = ["-140 m", 0, 0]}']
APART = (120, 140)  # m, of the centres at the start: smaller projectile, equal piles
# Name of the runs: what they are, changed keys, speeds in m/s, color.
SERIES = {
    "merge": ("friction 0.5, e = 0.3", [], (0.03, 0.1, 0.2, 0.3, 0.37, 0.45, 0.52, 0.6), "#2f6db3"),
    "merge-smooth": ("no friction, e = 0.5", SMOOTH, (0.2, 0.3, 0.4), "#3f8f5b"),
    "merge-frictionless": ("no friction, e = 0.3", ["contact.friction=0"], (0.2, 0.3, 0.4),
                           "#2a9d8f"),
    "merge-equal": ("equal piles, friction 0.5, e = 0.3", WHOLE, (0.2, 0.25, 0.3), "#7a5ea8"),
    "merge-equal-smooth": ("equal piles, no friction, e = 0.5", [*WHOLE, *SMOOTH],
                           (0.15, 0.2, 0.25), "#b5476b"),
}


def catastrophic_energy(target, projectile, c_star, mu=0.37):
    """J/kg: half of the mass is dispersed. Leinhardt & Stewart 2012 (ApJ 745:79), eqs. 28, 23: the
    principal curve c* 4/5 pi rho1 G R_C1^2 with R_C1 the radius of all mass at
    rho1 = 1000 kg/m^3, and the mass ratio's factor."""
    rho1 = 1000.0
    radius = (3 * (target + projectile) / (4 * np.pi * rho1)) ** (1 / 3)
    ratio = projectile / target
    return (c_star * 0.8 * np.pi * rho1 * G * radius**2
            * ((ratio + 1) ** 2 / (4 * ratio)) ** (2 / (3 * mu) - 1))


def folder_of(name, speed, seed):
    return pathlib.Path(f"out/{name}-{speed}-{seed}")


def read(name, speed, seed):
    folder = folder_of(name, speed, seed)
    position, velocity, radius, mass = last_frame(folder)
    with h5py.File(folder / "trajectory.h5") as file:
        group = file["particles/all/group"][:]
    target, projectile = mass[group == 0].sum(), mass[group == 1].sum()
    inside = largest_remnant(position, velocity, radius, mass)
    reduced = target * projectile / (target + projectile)
    # Speed at the contact of two spheres of the pile's density: the law's Q_R is that of the
    # impact.
    density = 2000 * results(pile(seed, settles=False))["pile"]["packing_fraction"]
    touch = sum((3 * m / (4 * np.pi * density)) ** (1 / 3) for m in (target, projectile))
    apart = APART["equal" in name]
    at_contact = speed**2 + 2 * G * mass.sum() * (1 / touch - 1 / apart)
    return {"speed": speed, "Q": reduced * at_contact / 2 / mass.sum(),
            "remnant": mass[inside].sum() / mass.sum(), "left": int((~inside).sum()),
            "target": target, "projectile": projectile,
            "escape": np.sqrt(2 * G * mass.sum() / touch), "at_contact": np.sqrt(at_contact),
            "drift": results(folder)["conservation"]["linear"]}


def fit(rows):
    """Q* (J/kg), slope of the largest remnant against Q / Q*, and the largest distance from the
    line: of what loses 3 to 90 % of its mass."""
    some = [(row["Q"], row["remnant"]) for row in rows if 0.1 <= row["remnant"] <= 0.97]
    if len(some) < 2:
        return None
    energy, remnant = np.array(some).T
    slope, offset = np.polyfit(energy, remnant, 1)
    half = (0.5 - offset) / slope
    return half, slope * half, np.max(np.abs(remnant - offset - slope * energy)), len(some)


def main():
    runs = [(folder_of(name, speed, seed), seed, [*keys, f"{PROJECTILE}.velocity=[{speed}, 0, 0]"])
            for name, (_, keys, speeds, _) in SERIES.items() for speed in speeds for seed in SEEDS]
    if "--only-table" not in sys.argv:
        run_all("cases/merge/case.toml", runs, ["target", "projectile"])
    made = commits(folder for folder, _, _ in runs if (folder / "results.toml").exists())
    lines = ["# Two piles meet head-on: the runs",
             f"Written by `cases/merge/run.py`, runs by commit {made}; 2 h after the start; "
             "mean ± standard deviation over piles of other seeds.", ""]
    fits = ["## The lines through them", "",
            "Leinhardt & Stewart: M_lr / M = 1 - Q_R / (2 Q*), so -0.5, and c* = 5 ± 2. Fitted to "
            "runs that lose 3 to 90 % of the mass.", "",
            "| | Q*, J/kg | c* | slope against Q_R / Q* "
            "| largest distance from the line, of the mass | runs |",
            "|---|--:|--:|--:|--:|--:|"]
    figure, panel = plt.subplots(figsize=(8, 4.2), layout="constrained")
    x = np.linspace(0, 2.6, 200)
    panel.fill_between(x, np.clip(1 - x / 2 * 5 / 3, 0, 1), np.clip(1 - x / 2 * 5 / 7, 0, 1),
                       color="#d9822b", alpha=0.2, lw=0,
                       label="Leinhardt & Stewart 2012, c* = 5 ± 2")
    panel.plot(x, np.clip(1 - x / 2, 0, 1), color="#d9822b")
    for name, (what, _, speeds, color) in SERIES.items():
        by_speed = [[read(name, speed, seed) for seed in SEEDS
                     if (folder_of(name, speed, seed) / "results.toml").exists()]
                    for speed in speeds]
        by_speed = [some for some in by_speed if some]
        rows = [row for some in by_speed for row in some]
        if not rows:
            continue
        target, projectile = rows[0]["target"], rows[0]["projectile"]
        curves = {c: catastrophic_energy(target, projectile, c) for c in (3, 5, 7)}
        lines += [f"## {what[0].upper()}{what[1:]}", "",
                  f"Target {target:.4g} kg, projectile {projectile:.4g} kg; they escape each other "
                  f"at {rows[0]['escape']:.3f} m/s; Q*: {curves[3]:.3g}, {curves[5]:.3g}, "
                  f"{curves[7]:.3g} J/kg for c* = 3, 5, 7.", "",
                  "| speed at the start, m/s | piles | at the contact | Q_R, J/kg "
                  "| Q_R / Q* (c* = 5) | largest remnant | 1 - Q_R / 2 Q* (c* = 3, 5, 7) "
                  "| bodies lost | drift of momentum |",
                  "|--:|--:|--:|--:|--:|--:|--:|--:|--:|"]
        for some in by_speed:
            row = some[0]
            law = ", ".join(f"{max(1 - row['Q'] / 2 / q, 0):.2f}" for q in curves.values())
            lines.append(f"| {row['speed']} | {len(some)} | {row['at_contact']:.3f} "
                         f"| {row['Q']:.3g} | {row['Q'] / curves[5]:.3g} "
                         f"| {scatter([one['remnant'] for one in some])} | {law} "
                         f"| {scatter([one['left'] for one in some])} "
                         f"| {max(one['drift'] for one in some):.1e} |")
        lines.append("")
        if line := fit(rows):
            half, slope, off, count = line
            fits.append(f"| {what} | {half:.3g} | {5 * half / curves[5]:.2f} | {slope:.3f} "
                        f"| {off:.3f} | {count} |")
        panel.errorbar([some[0]["Q"] / curves[5] for some in by_speed],
                       [np.mean([one["remnant"] for one in some]) for some in by_speed],
                       [np.std([one["remnant"] for one in some]) for some in by_speed],
                       fmt="o-", color=color, lw=0.8, label=what)
    (HERE / "results.md").write_text("\n".join([*lines, *fits]) + "\n")
    panel.set(xlabel="Q_R / Q* (c* = 5)", ylabel="largest remnant, of all mass", ylim=(0, 1.03))
    panel.legend(frameon=False, fontsize=8)
    panel.grid(color="#e4e8ee")
    figure.savefig(HERE / "remnants.png", dpi=110)


if __name__ == "__main__":
    main()
