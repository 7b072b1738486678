# A table of several impacts on the aggregate, beside the thesis: table.py RUN_FOLDER ...
# SPDX-License-Identifier: BSD-3-Clause
import math
import os
import sys
import tomllib

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../src/output"))
from report_reference import look_up, read_reference  # noqa: E402

ROWS = [("dv at 11 s", "read_out.dv[11]", "m/s"), ("dv at 51 s", "read_out.dv[51]", "m/s"),
        ("dv at 68 s", "read_out.dv[68]", "m/s"), ("dv at 90 s", "read_out.dv[90]", "m/s"),
        ("m v / M", "deflection.dv_plastic", "m/s"),
        ("m v (1 + e) / M", "deflection.dv_elastic", "m/s"),
        ("of dv at 90 s: the impactor", "deflection.dv_impactor", "m/s"),
        ("its rebound", "deflection.dv_rebound", "m/s"),
        ("the ejecta", "deflection.dv_ejecta", "m/s"),
        ("ejecta", "ejecta.count", ""), ("their mass", "ejecta.mass", "kg"),
        ("v_ejecta", "ejecta.v_ejecta", "m/s"), ("new period", "deflection.T_new_min", "min"),
        ("momentum not closed, of m v", "deflection.momentum_closure", ""),
        ("drift of momentum, of m v", "conservation.linear", ""),
        ("drift of angular momentum", "conservation.angular", ""),
        ("energy unexplained, of the dissipated", "conservation.energy_unexplained", "")]


def text(value):
    if value is None:
        return ""
    if isinstance(value, list):
        return " to ".join(text(one) for one in value)
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def print_table(heading, rows, left):
    """The first `left` columns and a note are text, the others numbers."""
    print("| " + " | ".join(heading) + " |")
    print("|" + "|".join("---" if k < left or name == "note" else "--:"
                         for k, name in enumerate(heading)) + "|")
    for row in rows:
        print("| " + " | ".join(row) + " |")


def main(folders):
    runs = []
    for folder in folders:
        with open(os.path.join(folder, "results.toml"), "rb") as file:
            results = tomllib.load(file)
        runs.append((results, read_reference(folder, results)))
    runs.sort(key=lambda run: look_up(run[0], "case.cohesion") or math.nan)
    names = [f"c = {text(look_up(results, 'case.cohesion'))} N" for results, _ in runs]

    print("## The runs\n")
    print_table(["", "", *names],
                [[name, unit, *(text(look_up(results, key)) for results, _ in runs)]
                 for name, key, unit in ROWS], 2)

    # What holds for every run is shown once, by the first.
    groups = [("The aggregate and momentum", runs[0][1], False)]
    groups += [(name, reference, True) for name, (_, reference) in zip(names, runs)]
    for name, reference, of_one in groups:
        rows = [[row.name, row.unit, row.source, text(row.printed), text(row.check),
                 text(row.result), row.note]
                for row in (reference.rows if reference else []) if bool(row.when) == of_one]
        if rows:
            print(f"\n## {name}\n")
            print_table(["", "", "source", "printed", "corrected", "Spall", "note"], rows, 3)


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit("usage: table.py <folder of a run> ...")
    main(sys.argv[1:])
