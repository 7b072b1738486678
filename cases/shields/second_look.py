"""Shoots the largest piece that met a wall, where that held, at the same wall again: alone, in the
form and the direction in which it flew, and with bodies that are small beside it. README.md tells
why.

    /usr/bin/python3 cases/shields/second_look.py [--until 16:45] [--jobs 2] [--rows 343 590]

What came of it is a line of second_look.csv, beside that of results.csv.
SPDX-License-Identifier: BSD-3-Clause
"""
import argparse
import concurrent.futures
import subprocess
import sys
import time
from pathlib import Path

from equations import read_shots
from largest_piece import form_of, largest_piece
from run import (BALLS, PLATES, RESULTS, ROOT, RULE, SECOND, SOUND, ask_for_runs, ask_for_setting,
                 end_of, is_of, keep, known)
from score import has_verdict

HERE = Path(__file__).parent
sys.path.append(str(HERE.parent / "breakup"))
from measure import FINE_ACROSS, narrow, results, shoot_form  # noqa: E402

# Times what the formula asks for: thicker walls are not shot at again, and hold. They would cost
# the most and tell least.
THICK = 2
WIDE = 2  # thicknesses that the wall is wide, at least
# Of sound through the wall: after so many the margin of a wall of 2 mm stood still, at 4 km/s.
PASSAGES = 16
COLUMNS = ["row", *vars(RULE), "piece_mm", "piece_km_s", "needs_mm", "verdict", "margin",
           "margin_before", "still_coming", "hole_mm", "unexplained_of_dissipated", "seconds",
           "commit"]


def look_again(options, shot, line):
    """A line of second_look.csv."""
    told = {key: line[key] for key in ("row", *vars(RULE))}
    wall, form = 1e-2 * shot.wall, form_of(line)
    if form is None:  # no piece was seen to fly at the wall alone
        return told | {"verdict": "held"}
    speed = -form.velocity[2]
    told |= {"piece_mm": f"{form.diameter:.4g}", "piece_km_s": f"{speed:.4g}",
             "needs_mm": f"{largest_piece(shot, float(line['largest_met_j'])).needs:.4g}"}
    if 1e3 * wall > THICK * float(told["needs_mm"]):
        return told | {"verdict": "held"}
    begin, diameter = time.monotonic(), 1e-3 * form.diameter
    spacing = diameter / FINE_ACROSS
    try:
        folder = shoot_form(
            options, "-".join(line[key] for key in ("row", *vars(RULE))),
            [1e-3 * one for one in form.size], [1e3 * one for one in form.velocity], wall,
            spacing, spacing, form.rotation,
            [*narrow(diameter, 1e3 * speed, WIDE * wall, PASSAGES * wall / SOUND),
             f"seed={1000 * int(line['seed']) + shot.row}",
             f"materials.piece.library={BALLS[shot.metals[0]]}",
             f"materials.wall.library={PLATES[shot.metals[2]]}"])
    except subprocess.CalledProcessError:
        return told | {"verdict": "failed"}
    found = results(folder)
    judged = found["shield_wall"]
    return told | {
        "verdict": judged["verdict"], "margin": f"{judged['margin']:.4g}",
        "margin_before": f"{judged['margins'][-2]:.4g}",
        "still_coming": f"{judged['still_coming']:.3g}", "hole_mm": f"{1e3 * judged['hole']:.4g}",
        "unexplained_of_dissipated": f"{found['conservation']['energy_unexplained']:.2e}",
        "seconds": f"{time.monotonic() - begin:.0f}", "commit": found["provenance"]["commit"]}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    ask_for_setting(parser)
    ask_for_runs(parser, ROOT / "out/shields_second")
    options = parser.parse_args()
    end, shots = end_of(options.until), read_shots()
    done = {line["row"] for line in known(SECOND) if is_of(line, options)}
    left = [line for line in known(RESULTS) if is_of(line, options) and has_verdict(line)
            and line["verdict"] == "held" and line["met_size_mm"] and line["row"] not in done]
    if options.rows:
        left = [line for line in left if int(line["row"]) in options.rows]

    def look(line):
        if time.time() < end:
            return look_again(options, shots[int(line["row"]) - 1], line)

    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        for task in concurrent.futures.as_completed([pool.submit(look, line) for line in left]):
            if task.result():
                keep(task.result(), COLUMNS, SECOND)
                print(*task.result().values(), flush=True)


if __name__ == "__main__":
    main()
