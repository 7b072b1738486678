# Basalt bodies of three sizes, hit ever harder: the largest remnant beside Benz & Asphaug 1999.
# SPDX-License-Identifier: BSD-3-Clause
"""run.py [--only-table] [--across N]: runs what is missing in out/, writes results.md and
remnants.png beside this script."""
import argparse
import pathlib
import sys

import h5py
import matplotlib
import numpy as np

HERE = pathlib.Path(__file__).parent
sys.path.insert(0, str(HERE.parent))
from remnants import (clump_names, commits, largest_remnant, results, run_all,  # noqa: E402
                      scatter)

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

SEEDS = (1, 2, 3)  # of flaws and of the crystals' orientations
SPEED, DENSITY = 5000.0, 2700.0  # m/s, kg/m^3
ACROSS = 24  # bodies across the target
# Name: radius in m, whether its pieces fly on under their gravity, parts of the formula's Q*.
SIZES = {"3 cm": (0.03, False, (0.1, 0.2, 0.4, 0.8, 1.6)),
         "300 m": (300.0, True, (0.25, 0.5, 1, 2)),
         "10 km": (1e4, True, (0.5, 1, 2, 4))}
# Name: what it is, changed keys.
ROCKS = {"slides": ("with Lundborg's strength, and friction once it has failed", []),
         "flows": ("as Benz & Asphaug have it",
                   [f"groups.{group}.material=flowing_basalt"
                    for group in ("target", "projectile")])}


KEYS = [(rock, name, part, seed) for seed in SEEDS for rock in ROCKS
        for name, (_, _, parts) in SIZES.items() for part in parts]


def breaks_until(name):
    """s: the case's 40 s, of a body of 10 km."""
    return 40 * SIZES[name][0] / 1e4


def threshold(radius):
    """J/kg, of a target of this radius (m): what leaves it half of its mass. Benz & Asphaug 1999,
    table 3, basalt at 5 km/s, means over the angles of impact; in erg/g for cm and g/cm^3."""
    cm = 100 * radius
    return 1e-4 * (9.0e7 * cm**-0.36 + 0.5 * DENSITY / 1000 * cm**1.36)


def changes(rock, name, part, seed, across):
    """Keys of the case for one run; places and times grow with the radius."""
    radius, flies, _ = SIZES[name]
    spacing = 2 * radius / across
    mass = part * threshold(radius) * 2 / SPEED**2  # over the target's
    own = radius * mass ** (1 / 3)
    # As fine as the target, or finer where it would be less than a body.
    own_spacing = 2 * own / max(1, round(2 * own / spacing))
    at = (radius + own + 0.6 * (spacing + own_spacing)) / np.sqrt(2)
    ends = breaks_until(name)
    keys = {"groups.target.volume.radius": radius, "groups.target.packing.diameter": spacing,
            "groups.projectile.volume.radius": own,
            "groups.projectile.volume.center": f"[{at}, 0, {at}]",
            "groups.projectile.packing.diameter": own_spacing, "seed": seed,
            "phases.breakup.step": ends / 200, "phases.breakup.duration": ends}
    if not flies:
        keys |= {"output.series_every": ends, "output.snapshot_every": 0}
    return [*(f"{key}={value}" for key, value in keys.items()), *ROCKS[rock][1]]


def folder_of(rock, name, part, seed, across):
    return pathlib.Path(f"out/monolith-{rock}-{name.replace(' ', '')}-{part}-{seed}-{across}")


def read(rock, name, part, seed, across):
    """Q in J/kg, and the largest remnant over the target's mass: the largest piece that is whole,
    and what gravity holds in the end."""
    folder = folder_of(rock, name, part, seed, across)
    with h5py.File(folder / "trajectory.h5") as file:
        rows = file["particles/all"]
        group, mass, radius = rows["group"][:], rows["mass"][:], rows["radius"][:]
        k = np.argmin(np.abs(rows["damage/time"][:] - breaks_until(name)))
        whole = (rows["damage/value"][k] < 1) & (group == 0)
        broken = rows["position/value"][k]
        position, velocity = rows["position/value"][-1], rows["velocity/value"][-1]
    target = mass[group == 0].sum()
    energy = mass[group == 1].sum() * SPEED**2 / 2
    pieces = clump_names(broken[whole], radius[whole], 0.4 * radius[group == 0][0])
    row = {"Q": energy / target, "piece": np.bincount(pieces, mass[whole]).max() / target,
           "unexplained": results(folder)["conservation"]["energy_unexplained"]}
    if SIZES[name][1]:
        bound = largest_remnant(position, velocity, radius, mass, 0.01 * radius.max())
        row["bound"] = mass[bound].sum() / target
    return row


def half_at(energy, remnant):
    """J/kg, where the largest remnant passes half of the mass, straight in ln Q; nan: nowhere."""
    for k in range(len(energy) - 1):
        if remnant[k] >= 0.5 > remnant[k + 1]:
            share = (remnant[k] - 0.5) / (remnant[k] - remnant[k + 1])
            return energy[k] * (energy[k + 1] / energy[k]) ** share
    return np.nan


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--only-table", action="store_true")
    parser.add_argument("--across", type=int, default=ACROSS)
    asked = parser.parse_args()
    for flies, case in ((False, "laboratory"), (True, "case")):
        runs = [(folder_of(*key, asked.across), key[-1], changes(*key, asked.across))
                for key in KEYS if SIZES[key[1]][1] == flies]
        if not asked.only_table:
            run_all(f"cases/monolith/{case}.toml", runs, [])
    write(asked.across)


def write(across):
    done = {key: read(*key, across) for key in KEYS
            if (folder_of(*key, across) / "results.toml").exists()}
    made = commits(folder_of(*key, across) for key in done)
    lines = ["# Basalt bodies, hit at 5 km/s and 45 degrees: the runs",
             f"Written by `cases/monolith/run.py`, runs by commit {made}; {across} bodies across a "
             "target; mean ± standard deviation over seeds, which draw flaws and orientations.",
             "", "| rock | radius | Q*, J/kg, of each seed | Benz & Asphaug | ratio |",
             "|---|---|--:|--:|--:|"]
    figure, panels = plt.subplots(1, len(SIZES), figsize=(10, 3.2), sharey=True,
                                  layout="constrained")
    tables = []
    for (rock, (told, _)), color in zip(ROCKS.items(), ("#2f6db3", "#b5476b")):
        for (name, (radius, flies, parts)), panel in zip(SIZES.items(), panels):
            known, what = threshold(radius), "bound" if flies else "piece"
            halves = []
            for seed in SEEDS:
                rows = [done[rock, name, part, seed] for part in parts
                        if (rock, name, part, seed) in done]
                energy, remnant = ([row[key] for row in rows] for key in ("Q", what))
                halves.append(half_at(energy, remnant))
                panel.semilogx(np.array(energy) / known, remnant, "o-", ms=3, lw=0.8, color=color,
                               label=rock if seed == SEEDS[0] else None)
            lines.append(f"| {told} | {name} | {', '.join(f'{one:.3g}' for one in halves)} "
                         f"| {known:.3g} | {scatter(np.array(halves) / known)} |")
            tables += table_of(rock, name, done)
    for name, panel in zip(SIZES, panels):
        panel.axvspan(0.5, 2, color="#d9822b", alpha=0.15, lw=0)
        panel.axhline(0.5, color="#888", lw=0.6)
        panel.set(title=f"radius {name}", xlabel="Q / Q* of Benz & Asphaug 1999", ylim=(0, 1.03),
                  xlim=(0.1, 6))
        panel.set_xticks((0.1, 0.2, 0.5, 1, 2, 5), ("0.1", "0.2", "0.5", "1", "2", "5"))
        panel.minorticks_off()
    panels[0].set(ylabel="largest remnant over target")
    panels[0].legend(title="rock that", loc="lower left", frameon=False)
    (HERE / "results.md").write_text("\n".join(lines + tables) + "\n")
    figure.savefig(HERE / "remnants.png", dpi=110)


def table_of(rock, name, done):
    """Lines of the table of one rock and size."""
    radius, flies, parts = SIZES[name]
    lines = ["", f"## Radius {name}, rock {ROCKS[rock][0]}", "",
             "| Q, J/kg | Q / Q* | largest piece that is whole | held by gravity in the end "
             "| energy unexplained, of what was dissipated |", "|--:|--:|--:|--:|--:|"]
    for part in parts:
        rows = [done[rock, name, part, seed] for seed in SEEDS if (rock, name, part, seed) in done]
        if not rows:
            continue
        bound = scatter([row["bound"] for row in rows]) if flies else ""
        energy = np.mean([row["Q"] for row in rows])
        lines.append(f"| {energy:.3g} | {energy / threshold(radius):.2f} "
                     f"| {scatter([row['piece'] for row in rows])} | {bound} "
                     f"| {max(abs(row['unexplained']) for row in rows):.1e} |")
    return lines


if __name__ == "__main__":
    main()
