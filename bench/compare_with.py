#!/usr/bin/env python3
"""Compares two builds body by body: every case after one step, and after fifty, of each phase.
usage: compare_with.py BASE_BINARY THIS_BINARY [--steps 1 50] [--ranks 1] [--only REGEX]

A binary reads the cases of its own tree (the folder above its build), so that keys may change
between the two. Phases are shortened to so many steps; all of them run, each from where the one
before ended. Rows say the largest difference of a body's position, of the mean radius, and of its
velocity, of the largest speed. Cases that start from stored piles get the cloud of cases/pile, as
the base leaves it after fifty steps. Cases with more bodies than --most are compared after one step
alone. The table goes to stdout; what could not be compared is named with the reason.

SPDX-License-Identifier: BSD-3-Clause
"""
import argparse
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

import h5py
import numpy


def tree_of(binary):
    """The nearest folder above that has cases."""
    for folder in binary.resolve().parents:
        if (folder / "cases").is_dir():
            return folder
    sys.exit(f"{binary}: no folder above has cases")


def times(text, count):
    """A duration of so many steps, in the step's own unit."""
    value, unit = re.fullmatch(r"\s*([-+.\deE]+)\s*(.*)", str(text)).groups()
    return f"{float(value) * count!r} {unit}".strip()


def shortened(case, steps):
    """Arguments that let every phase last so many steps."""
    with open(case, "rb") as file:
        phases = tomllib.load(file)["phases"]
    return [f"--set=phases.{p['name']}.duration={times(p['step'], steps)}" for p in phases]


def names_of_phases(case):
    with open(case, "rb") as file:
        return [phase["name"] for phase in tomllib.load(file)["phases"]]


def spall(binary, arguments, work, ranks=1, limit=1200):
    """Nothing, or the last words of a run that failed."""
    command = ["mpirun", "--oversubscribe", "-n", str(ranks), binary, *arguments]
    try:
        done = subprocess.run(command, cwd=work, capture_output=True, text=True, timeout=limit)
    except subprocess.TimeoutExpired:
        return f"longer than {limit} s"
    if done.returncode == 0:
        return ""
    said = re.findall(r"spall: (.*)", done.stdout + done.stderr)
    return said[0] if said else f"exit code {done.returncode}"


def bodies_in(case, binary):
    said = subprocess.run([binary, "check", case], capture_output=True, text=True).stdout
    found = re.search(r"(\d+) bodies, ", said)
    return int(found[1]) if found else sys.exit(f"{case}: spall check tells no bodies")


def rows_of(file):
    """Bodies by id: a field each."""
    with h5py.File(file) as stored:
        bodies = {name: stored[f"bodies/{name}"][()] for name in
                  ("id", "radius", "position", "velocity")}
    order = numpy.argsort(bodies["id"])
    return {name: field[order] for name, field in bodies.items()}


def difference(file, other):
    """Bodies, whether all bits are the same, and the largest differences over their scales."""
    a, b = rows_of(file), rows_of(other)
    if not numpy.array_equal(a["id"], b["id"]):
        return len(a["id"]), False, numpy.nan, numpy.nan

    def largest(field, scale):
        apart = numpy.linalg.norm(b[field] - a[field], axis=1).max()
        return apart / scale if apart > 0 else 0.0
    speeds = numpy.linalg.norm(a["velocity"], axis=1)
    same = all(a[name].tobytes() == b[name].tobytes() for name in a)
    return (len(a["id"]), same, largest("position", a["radius"].mean()),
            largest("velocity", speeds.max() or 1.0))


def compare(name, binaries, trees, steps, ranks):
    """Rows of the table, or a reason why there are none."""
    out = []
    for binary, tree in zip(binaries, trees):
        case = tree / "cases" / name
        if not case.is_file():
            return f"{tree.name} has no such case"
        out.append(tree / "out" / "compared")
        shutil.rmtree(out[-1], ignore_errors=True)
        words = ["run", case, "--out", out[-1], *shortened(case, steps)]
        failed = spall(binary, words, tree, ranks)
        if failed:
            return f"{tree.name}: {failed}"
    rows = []
    for phase in names_of_phases(trees[1] / "cases" / name):
        files = [folder / f"after_{phase}.h5" for folder in out]
        if not all(file.is_file() for file in files):
            return f"no state after the phase {phase} of both"
        count, same, apart, faster = difference(*files)
        rows.append(f"| {name} | {phase} | {steps} | {count} | {'same bits' if same else ''} | "
                    f"{apart:.1e} | {faster:.1e} |")
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("base", type=Path)
    parser.add_argument("this", type=Path)
    parser.add_argument("--steps", type=int, nargs="+", default=[1, 50])
    parser.add_argument("--ranks", type=int, default=1)
    parser.add_argument("--only", default="", help="regular expression that the case must hold")
    parser.add_argument("--most", type=int, default=200000, help="bodies for more than one step")
    args = parser.parse_args()
    binaries = [args.base.resolve(), args.this.resolve()]
    skipped = []
    print("| case | phase | steps of each phase | bodies | bits | position, of the mean radius | "
          "velocity, of the largest speed |\n|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        trees = [Path(folder) / "base", Path(folder) / "this"]  # copies: runs write beside cases
        for binary, tree in zip(binaries, trees):
            shutil.copytree(tree_of(binary) / "cases", tree / "cases")
        pile = trees[0] / "cases" / "pile" / "case.toml"
        failed = spall(binaries[0], ["run", pile, "--out", trees[0] / "out" / "pile",
                                     *shortened(pile, 50)], trees[0])
        if failed:
            skipped.append(f"the cloud of cases/pile could not be made: {failed}")
        else:
            shutil.copytree(trees[0] / "out" / "pile", trees[1] / "out" / "pile")
        for case in sorted(trees[1].glob("cases/*/*.toml")):
            name = str(case.relative_to(trees[1] / "cases"))
            if "[[phases]]" not in case.read_text() or not re.search(args.only, name):
                continue
            many = bodies_in(case, binaries[1]) > args.most
            for steps in args.steps:
                if many and steps > 1:
                    skipped.append(f"{name}, {steps} steps: more than {args.most} bodies")
                    continue
                rows = compare(name, binaries, trees, steps, args.ranks)
                if isinstance(rows, str):
                    skipped.append(f"{name}, {steps} steps: {rows}")
                else:
                    print("\n".join(rows), flush=True)
    print("\nNot compared:\n" + "\n".join(f"- {line}" for line in skipped) if skipped else "")


if __name__ == "__main__":
    main()
