"""Runs two of Piekutowski's shots as solids that yield, finer and finer: do the figures converge?

    python3 cases/plate_solid/converge.py [--across 8 12] [--seeds 1 2 3] [--shots 4-1287 4-1353]
    [--table]

Each run is case.toml with other sizes; what it gave is kept in results.csv, and all of it makes
the table of README.md (--table: only that).
SPDX-License-Identifier: BSD-3-Clause
"""
import argparse
import csv
import math
import re
import statistics
import sys
import tomllib
from pathlib import Path

HERE = Path(__file__).parent
ROOT = HERE.parent.parent
sys.path += [str(HERE.parent), str(HERE.parent / "plate"), str(HERE.parent / "shields"),
             str(ROOT / "bench")]
from program import PROGRAM, spall  # noqa: E402
from readme import replace_section  # noqa: E402
from run import mass_of_ball  # noqa: E402
from shots import DENSITY, front_band, holes, shot  # noqa: E402

WIDTH = {"4-1287": 4, "4-1353": 5}  # of the plate, in diameters
UNTIL = {"4-1287": 16e-6, "4-1353": 24e-6}  # s: the hole stands still
# A sheet of few layers has whole ones, close-packed, as many as a ball has bodies across over this.
# The others are crystals that are turned at random, as fine as the ball's.
ACROSS_A_LAYER = {"4-1287": 4}
LAYER = math.sqrt(2 / 3)  # of the spacing
COURANT = 0.2
KEY = ["shot", "across", "seed"]
KEPT = ["front_over_speed", "radial_over_speed", "hole_over_diameter",
        "projectile_melted", "plate_melted"]
COLUMNS = [*KEY, "layers", *KEPT, "hole_before", "plate_mass_over_projectile", "bodies",
           "energy", "momentum", "seconds", "commit"]


def changes(name, across, seed, grown=1):
    """`grown`: times which the ball and its spacing are as large, for its mass."""
    speed, thickness, diameter = shot(name)
    width = WIDTH[name] * diameter
    diameter *= grown
    spacing = diameter / across
    if name in ACROSS_A_LAYER:
        layers = round(across / ACROSS_A_LAYER[name])
        sheet = thickness / (layers * LAYER)  # so that mass over area is that of the sheet
        depth = thickness + (1 - LAYER) * sheet
        packing = 'kind = "hcp", orientation = "rotation"'
    else:
        layers = round(thickness / spacing)
        depth, sheet = thickness, thickness / layers
        packing = 'kind = "fcc", orientation = "random"'
    return layers, [
        f"seed={seed}", f"solid.courant={COURANT}",
        f"groups.plate.volume.size=[{width}, {width}, {depth}]",
        f"groups.plate.volume.center=[0, 0, {-thickness / 2}]",
        f"groups.plate.packing={{{packing}, diameter = {sheet}}}",
        f"groups.ball.volume.diameter={diameter}",
        f"groups.ball.volume.center=[0, 0, {diameter / 2 + 1.05 * max(spacing, sheet)}]",
        f"groups.ball.packing.diameter={spacing}",
        f"groups.ball.velocity=[0, 0, {-speed}]",
        f"phases.impact.step={UNTIL[name] / 200}", f"phases.impact.duration={UNTIL[name]}",
        f"debris.every={UNTIL[name] / 12}", f"output.series_every={UNTIL[name] / 50}",
        f"output.snapshot_every={UNTIL[name] / 4}"]


def run(options, name, across, seed):
    speed, _, diameter = shot(name)
    ball = DENSITY * math.pi / 6 * diameter**3  # kg
    layers, changed = changes(name, across, seed)
    case = HERE / "case.toml"
    told = spall("check", case, changes=changed, program=options.program)
    folder = ROOT / "out/plate_solid" / f"{name}-{across:g}-{seed}"
    _, changed = changes(name, across, seed, (ball / mass_of_ball(told))**(1 / 3))
    spall("run", case, "--out", folder, "--overwrite", changes=changed, ranks=options.ranks,
          program=options.program)
    results = tomllib.loads((folder / "results.toml").read_text())
    debris, cloud, conservation = (results[key] for key in ("debris", "cloud", "conservation"))
    with open(folder / "series.csv") as file:
        unexplained = max(abs(float(row["unexplained"])) for row in csv.DictReader(file))
    return {"shot": name, "across": f"{across:g}", "seed": f"{seed}", "layers": layers,
            **{key: f"{debris[key]:.4f}" for key in KEPT},
            "hole_before": f"{cloud['hole'][len(cloud['hole']) * 2 // 3] / diameter:.4f}",
            "plate_mass_over_projectile": f"{debris['plate_mass'] / ball:.4f}",
            "bodies": re.search(r"(\d+) bodies, ", told)[1],
            "energy": f"{unexplained / (0.5 * ball * speed**2):.2e}",
            "momentum": f"{conservation['linear']:.1e}",
            "seconds": f"{results['time']['total_s']:.0f}",
            "commit": results["provenance"]["commit"]}


def table(rows):
    lines = ["| shot | across | layers | seeds | front / V | bounds | radial / V | hole / D | "
             "formulas | growth | plate's debris, of the ball's mass | energy |",
             "|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|"]
    for name in UNTIL:
        speed, thickness, diameter = shot(name)
        ratio = thickness / diameter
        low, high = front_band(ratio)
        least, most = holes(speed, ratio)
        for across in sorted({float(row["across"]) for row in rows if row["shot"] == name}):
            chosen = [row for row in rows
                      if row["shot"] == name and float(row["across"]) == across]

            def spread(key, form):
                values = [float(row[key]) for row in chosen]
                return f"{statistics.mean(values):{form}}" + (
                    f" ({min(values):{form}}–{max(values):{form}})" if len(values) > 1 else "")

            growth = statistics.mean(float(row["hole_over_diameter"]) / float(row["hole_before"])
                                     for row in chosen) - 1
            energy = max(float(row["energy"]) for row in chosen)
            lines.append(f"| {name} | {across:g} | {chosen[0]['layers']} | {len(chosen)} | "
                         f"{spread('front_over_speed', '.3f')} | {low:.2f}–{high:.2f} | "
                         f"{spread('radial_over_speed', '.3f')} | "
                         f"{spread('hole_over_diameter', '.2f')} | {least:.2f}–{most:.2f} | "
                         f"{100 * growth:.0f} % | "
                         f"{spread('plate_mass_over_projectile', '.2f')} | {100 * energy:.2f} % |")
    seconds = sum(float(row["seconds"]) for row in rows)
    lines += ["", f"Mean (least–most) over seeds, each of another orientation of the crystals. "
              f"Growth of the hole over the last third of a run. Energy: the most that no entry "
              f"explained at any time, of the impact's. {seconds / 3600:.1f} hours, one rank each. "
              f"Commits: {', '.join(sorted({row['commit'] for row in rows}))}."]
    return "\n".join(lines)


def halvings(rows):
    """What the last halving of the bodies, 12 to 24 across, changed."""
    lines = ["| shot | front | hole | radial speed |", "|---|--:|--:|--:|"]
    for name in UNTIL:
        def mean(key, across):
            return statistics.mean(float(row[key]) for row in rows
                                   if row["shot"] == name and float(row["across"]) == across)

        changed = [100 * (mean(key, 24) / mean(key, 12) - 1)
                   for key in ("front_over_speed", "hole_over_diameter", "radial_over_speed")]
        lines.append(f"| {name} | " + " | ".join(f"{share:+.1f} %" for share in changed) + " |")
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--across", type=float, nargs="+", default=[8, 12])
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3])
    parser.add_argument("--shots", nargs="+", default=list(UNTIL))
    parser.add_argument("--ranks", type=int, default=1)
    parser.add_argument("--program", type=Path, default=PROGRAM)
    parser.add_argument("--table", action="store_true", help="run nothing")
    options = parser.parse_args()
    path = HERE / "results.csv"

    def known():
        return list(csv.DictReader(path.open())) if path.exists() else []

    if not options.table:
        for across in options.across:
            for name in options.shots:
                for seed in options.seeds:
                    if any([row[key] for key in KEY] == [name, f"{across:g}", f"{seed}"]
                           for row in known()):
                        continue
                    row = run(options, name, across, seed)
                    rows = [*known(), row]
                    print(*row.values(), flush=True)
                    with path.open("w", newline="") as file:
                        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
                        writer.writeheader()
                        writer.writerows(rows)
    replace_section(HERE / "README.md", "convergence", table(known()))
    if {(name, "24") for name in UNTIL} <= {(row["shot"], row["across"]) for row in known()}:
        replace_section(HERE / "README.md", "halvings", halvings(known()))


if __name__ == "__main__":
    main()
