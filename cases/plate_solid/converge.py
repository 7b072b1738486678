"""Runs spheres through plates as solids that yield, two of them finer and finer: do the figures
converge?

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
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).parent
ROOT = HERE.parent.parent
sys.path += [str(HERE.parent), str(HERE.parent / "plate"), str(HERE.parent / "shields"),
             str(ROOT / "bench")]
from program import PROGRAM, spall  # noqa: E402
from readme import replace_section  # noqa: E402
from run import mass_of_ball  # noqa: E402
from shots import DENSITY, known_of, shot  # noqa: E402


@dataclass(frozen=True)
class Plate:
    width: float  # diameters of the ball
    until: float  # s: the hole stands still
    # A sheet of few layers has whole ones, close-packed, as many as a ball has bodies across over
    # this. The others are crystals that are turned at random, as fine as the ball's.
    across_a_layer: float = 0


PLATES = {"4-1395": Plate(4, 16e-6, 6), "4-1360": Plate(4, 16e-6, 6), "4-1359": Plate(4, 16e-6, 6),
          "4-1287": Plate(4, 16e-6, 4), "4-1283": Plate(4, 16e-6, 4), "4-1291": Plate(5, 20e-6, 3),
          "4-1351": Plate(5, 24e-6, 3), "4-1353": Plate(5, 24e-6), "hiermaier": Plate(5, 24e-6)}
CONVERGING = ("4-1287", "4-1353")
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
    plate = PLATES[name]
    width = plate.width * diameter
    diameter *= grown
    spacing = diameter / across
    if plate.across_a_layer:
        layers = round(across / plate.across_a_layer)
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
        f"phases.impact.step={plate.until / 200}", f"phases.impact.duration={plate.until}",
        f"debris.every={plate.until / 12}", f"output.series_every={plate.until / 50}",
        f"output.snapshot_every={plate.until / 4}"]


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
    for name in PLATES:
        band, (least, most) = known_of(name)
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
                         f"{spread('front_over_speed', '.3f')} | {band} | "
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
    for name in CONVERGING:
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
    parser.add_argument("--shots", nargs="+", default=CONVERGING)
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
    if {(name, "24") for name in CONVERGING} <= {(row["shot"], row["across"]) for row in known()}:
        replace_section(HERE / "README.md", "halvings", halvings(known()))


if __name__ == "__main__":
    main()
