"""Shoots balls of copper, titanium and nylon at shields of aluminium: the table of README.md.

    python3 cases/shields/two_materials.py [--across 6] [--only-table]

Which shots stands in two_materials.csv. Shots that are missing in two_materials_results.csv are
run, as run.py sets them up.
SPDX-License-Identifier: BSD-3-Clause
"""
import argparse
import math
import sys
from pathlib import Path

import run
from equations import is_right, read_shots
from score import BEST, FAILED, has_verdict

HERE = Path(__file__).parent
RESULTS = HERE / "two_materials_results.csv"
WALL_ACROSS = 3  # walls are up to three diameters thick: 9 layers, or the 3 of the rule
sys.path.append(str(HERE.parent.parent / "bench"))
from readme import replace_section  # noqa: E402


def table(shots):
    lines = ["| shot | ball | km/s | bumper, gap, wall, mm | experiment | Spall | margin "
             f"| hole, mm | {BEST} |", "|---|---|--:|---|---|---|--:|--:|---|"]
    right, equation = 0, 0
    rows = [row for row in run.known(RESULTS) if has_verdict(row)]
    for row in rows:
        shot = shots[int(row["row"]) - 1]
        called = is_right(shot, BEST) == shot.perforated  # perforated
        right += FAILED[row["verdict"]] == shot.perforated
        equation += is_right(shot, BEST)
        lines.append(f"| {shot.name} | {shot.metals[0]} {10 * shot.diameter:g} mm "
                     f"| {shot.speed:g} | "
                     f"{10 * shot.bumper:g}, {10 * shot.standoff:g}, {10 * shot.wall:g} | "
                     f"{'perforated' if shot.perforated else 'held'} | {row['verdict']} | "
                     f"{float(row['margin']):.2f} | {row['hole_mm']} | "
                     f"{'perforated' if called else 'held'} |")
    if not rows:
        return "None has been run."
    worst = max(float(row["energy_unexplained"]) for row in rows)
    lines += ["", f"Right: Spall {right} of {len(rows)} that have a verdict, {BEST} {equation}. "
              f"{rows[0]['across']} across, the wall "
              f"{WALL_ACROSS}, one seed. Energy that no entry explains: at most "
              f"{100 * worst:.2g} % of the impact's. Commits: "
              f"{', '.join(sorted({row['commit'] for row in rows}))}."]
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--across", type=float, default=run.RULE.across)
    parser.add_argument("--only-table", action="store_true", help="run nothing")
    parser.add_argument("--program", default=run.ROOT / "build/release/spall")
    parser.add_argument("--out", type=Path, default=run.ROOT / "out/shields_two")
    options = argparse.Namespace(**vars(run.RULE) | {
        "wall_across": WALL_ACROSS, "before": [], "limit": math.inf} | vars(parser.parse_args()))
    shots = read_shots(HERE / "two_materials.csv")
    done = {row["row"] for row in run.known(RESULTS)}
    for shot in shots:
        if not options.only_table and str(shot.row) not in done:
            run.keep(run.run(options, shot), run.COLUMNS, RESULTS)
    replace_section(HERE / "README.md", "two_materials", table(shots))


if __name__ == "__main__":
    main()
