"""Shoots the largest piece that met a wall, where that held, at the same wall again, alone and with
bodies that are small beside it. README.md tells why.

    /usr/bin/python3 cases/shields/second_look.py [--until 16:45] [--jobs 2] [--rows 343 590]

What came of it is a line of second_look.csv, beside that of results.csv.
SPDX-License-Identifier: BSD-3-Clause
"""
import argparse
import concurrent.futures
import sys
import time
from pathlib import Path

from equations import read_shots
from largest_piece import largest_piece
from run import (BALLS, PLATES, RESULTS, ROOT, RULE, SECOND, ask_for_setting, end_of, is_of, keep,
                 known)

HERE = Path(__file__).parent
sys.path.append(str(HERE.parent / "breakup"))
from measure import FINE, narrow, results, shoot_piece  # noqa: E402

# Times what the formula asks for: thicker walls are not looked at again, and hold. They would cost
# the most and tell least.
THICK = 2
COLUMNS = ["row", *vars(RULE), "piece_mm", "piece_km_s", "needs_mm", "verdict", "margin", "hole_mm",
           "energy_unexplained", "seconds", "commit"]


def is_thick(shot, piece):
    return 10 * shot.wall > THICK * piece.needs


def look_again(options, shot, line):
    """A line of second_look.csv."""
    piece = largest_piece(shot, float(line["largest_met_j"]))
    told = {key: line[key] for key in ("row", *vars(RULE))} | {
        "piece_mm": f"{piece.diameter:.4g}", "piece_km_s": f"{piece.speed:.4g}",
        "needs_mm": f"{piece.needs:.4g}"}
    if is_thick(shot, piece):
        return told | {"verdict": "held"}
    begin, spacing = time.monotonic(), 1e-3 * piece.diameter / FINE
    ball, _, wall = shot.metals
    folder = shoot_piece(options, str(shot.row), 1e-3 * piece.diameter, 1e3 * piece.speed,
                         1e-2 * shot.wall, spacing, spacing,
                         [*narrow(piece.diameter, piece.speed),
                          f"materials.piece.library={BALLS[ball]}",
                          f"materials.wall.library={PLATES[wall]}"])
    found = results(folder)
    judged = found["shield_wall"]
    return told | {
        "verdict": judged["verdict"], "margin": f"{judged['margin']:.4g}",
        "hole_mm": f"{1e3 * judged['hole']:.4g}",
        "energy_unexplained": f"{found['conservation']['energy_unexplained']:.2e}",
        "seconds": f"{time.monotonic() - begin:.0f}",
        "commit": found["provenance"]["commit"]}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    ask_for_setting(parser)
    parser.add_argument("--rows", type=int, nargs="+", metavar="ROW", help="these alone")
    parser.add_argument("--until", metavar="HH:MM", help="nothing is begun later today")
    parser.add_argument("--jobs", type=int, default=1, help="runs at a time, one rank each")
    parser.add_argument("--program", default=ROOT / "build/release/spall")
    parser.add_argument("--before", default="", help='put before the program, such as "nice -n 5"')
    parser.add_argument("--out", type=Path, default=ROOT / "out/shields_second")
    options = parser.parse_args()
    end, shots = end_of(options.until), read_shots()
    done = {line["row"] for line in known(SECOND) if is_of(line, options)}
    left = [line for line in known(RESULTS) if is_of(line, options) and line["verdict"] == "held"
            and line["row"] not in done]
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
