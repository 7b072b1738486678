"""Beside the shots: 4-1353 at other speeds, an oblique impact and a Whipple shield; writes their
tables.

    python3 cases/plate/others.py [--ranks 2] [--only speeds oblique whipple] [--table]

What the runs gave is kept in cases/plate/others.json. Minutes on two cores.
SPDX-License-Identifier: BSD-3-Clause
"""
import argparse
import json
import tomllib
from pathlib import Path

import shots
from program import PROGRAM, spall  # noqa: E402  (shots knows where these are)
from readme import replace_section  # noqa: E402

HERE = Path(__file__).parent
KEPT = HERE / "others.json"
SPEEDS = [3000, 4000, 5000, 6680, 8000]  # m/s


def results_of(case, folder, options, changes=()):
    spall("run", case, "--out", folder, "--overwrite", changes=changes, ranks=options.ranks,
          program=options.program)
    return tomllib.loads((folder / "results.toml").read_text())


def run_speeds(options):
    rows = []
    for speed in SPEEDS:
        chosen = argparse.Namespace(across=8, width=5, duration=80e-6, pictures=False,
                                    ranks=options.ranks,
                                    program=options.program, set=[], speed=speed)
        rows.append([{**shots.run(chosen, "4-1353", seed), "speed": speed} for seed in (1, 2, 3)])
    return rows


def run_case(name, options):
    results = results_of(shots.ROOT / f"cases/{name}/case.toml", shots.ROOT / f"out/{name}",
                         options)
    return {part: results[part] for part in ("debris", "cloud", "wall", "fragments", "conservation")
            if part in results}


def speeds_table(kept):
    lines = ["| speed, km/s | front / V | radial / V | hole / D | Maiden–McMillan, Sawle | molten "
             "| pieces |",
             "|--:|--:|--:|--:|--:|--:|--:|"]
    _, thickness, diameter = shots.shot("4-1353")
    for rows in kept:
        def spread(key, form=".2f"):
            values = [float(row[key]) for row in rows]
            return f"{sum(values) / len(values):{form}} ({min(values):{form}}–{max(values):{form}})"

        speed = rows[0]["speed"]
        low, high = shots.holes(speed, thickness / diameter)
        lines.append(f"| {speed / 1e3:g} | {spread('front_over_speed', '.3f')} | "
                     f"{spread('radial_over_speed')} | "
                     f"{spread('hole_over_diameter')} | {low:.2f}–{high:.2f} | "
                     f"{100 * sum(float(r['projectile_melted']) for r in rows) / len(rows):.0f} % "
                     f"| "
                     f"{sum(r['pieces'] for r in rows) / len(rows):.0f} |")
    return "\n".join(lines)


def cases_table(oblique, whipple):
    def share(results, key):
        debris = results["debris"]
        return debris[key] / (mass_of_ball(results) * debris["speed"])

    def mass_of_ball(results):
        return shots.DENSITY * 3.14159265 / 6 * results["debris"]["diameter"]**3

    def row(what, value):
        return f"| {what} | " + " | ".join(value(results) for results in (oblique, whipple)) + " |"

    def load(key, form, scale=1.0):
        return lambda r: f"{scale * r['wall'][key]:{form}}" if "wall" in r else ""

    lines = ["| behind | the oblique plate | the shield's wall |", "|---|--:|--:|",
             row("front / V, along the normal", lambda r: f"{r['debris']['front_over_speed']:.3f}"),
             row("centre / V", lambda r: f"{r['debris']['centre'] / r['debris']['speed']:.3f}"),
             row("radial / V", lambda r: f"{r['debris']['radial_over_speed']:.2f}"),
             row("hole / D, spread over sectors",
                 lambda r: f"{r['debris']['hole_over_diameter']:.2f} ± "
                 f"{r['debris']['hole_spread'] / r['debris']['diameter']:.2f}"),
             row("mass of the sphere, of its own",
                 lambda r: f"{r['debris']['projectile_mass'] / mass_of_ball(r):.2f}"),
             row("mass of the plate, of the sphere's",
                 lambda r: f"{r['debris']['plate_mass'] / mass_of_ball(r):.2f}"),
             row("momentum along the normal, of the sphere's",
                 lambda r: f"{share(r, 'momentum_forward'):.2f}"),
             row("what is left of the plate flies at, m/s",
                 lambda r: f"{r['debris']['plate_speed']:.0f}"),
             row("half, 90 % of the momentum within, mm, 100 mm behind",
                 lambda r: load("half_radius", ".0f", 1e3)(r) and
                 f"{load('half_radius', '.0f', 1e3)(r)}, {load('radius', '.0f', 1e3)(r)}"),
             row("largest load there, kPa s", load("peak", ".2f", 1e-3)),
             row("pieces, single bodies",
                 lambda r: f"{r['fragments']['pieces']}, {r['fragments']['singles']}")]
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--ranks", type=int, default=2)
    parser.add_argument("--program", type=Path, default=PROGRAM)
    parser.add_argument("--only", nargs="+", default=["speeds", "oblique", "whipple"])
    parser.add_argument("--table", action="store_true", help="run nothing")
    options = parser.parse_args()
    kept = json.loads(KEPT.read_text()) if KEPT.exists() else {}
    for name in [] if options.table else options.only:
        kept[name] = run_speeds(options) if name == "speeds" else run_case(name, options)
        KEPT.write_text(json.dumps(kept, indent=1) + "\n")
    replace_section(HERE / "README.md", "speeds", speeds_table(kept["speeds"]))
    replace_section(HERE / "README.md", "others", cases_table(kept["oblique"], kept["whipple"]))


if __name__ == "__main__":
    main()
