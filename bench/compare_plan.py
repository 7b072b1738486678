"""Compares `spall plan` with runs on as many ranks, and puts the table into bench/README.md.

SPDX-License-Identifier: BSD-3-Clause
usage: compare_plan.py SPALL CSV RANKS ...
"""
import csv
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import tomllib

from readme import replace_section

HERE = pathlib.Path(__file__).resolve().parent
CASE = HERE / "plan.toml"
METHODS = {"nonsmooth": [], "penalty": [], "potential": [],
           "nonsmooth, gravity by a tree": ["--set", "gravity.method=tree", "--set",
                                            "gravity.accuracy=1e-3"]}
STAGES = ("gravity", "neighbours", "forces", "solver")
COUNTS = ("messages", "bytes", "collectives")
SECONDS = {"us": 1e-6, "ms": 1e-3, "s": 1}
TIMED = os.cpu_count()  # ranks, at most, that have a core each


def call(*words):
    done = subprocess.run(words, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, words))}: {done.stderr}")
    return done.stdout


def on_ranks(ranks, *words):
    return call("mpirun", "--oversubscribe", "-n", str(ranks), *words)


def bodies_of(spall, changes):
    return int(re.search(r"(\d+) bodies, at most", call(spall, "check", CASE, *changes))[1])


def seconds(text):
    value, unit = re.search(r"([\d.e+-]+) (us|ms|s)\b", text).groups()
    return float(value) * SECONDS[unit]


def blocks(text):
    """Of a plan's text: number of ranks, its rows by name, and the block itself."""
    for count, block in re.findall(r"^(\d+) ranks?, (.*?)(?:\n\n|\Z)", text, re.M | re.S):
        yield int(count), {line[2:18].strip(): line[18:].split()
                           for line in block.splitlines()[1:]}, block


def planned(spall, changes, ranks):
    """By number of ranks, what the plan tells of a step of the slowest one."""
    text = on_ranks(2, spall, "plan", CASE, "--ranks", ",".join(map(str, ranks)), "--calibrate",
                    *changes)
    plans = {}
    for count, rows, block in blocks(text):
        plan = plans[count] = {"bodies": float(rows["bodies"][1])}
        for stage in STAGES:
            plan |= {f"{stage} {what}": float(rows[stage][k]) for k, what in enumerate(COUNTS)
                     if stage in rows}
        plan["step (s)"] = seconds(re.search(r"a step takes (.*?),", block)[1])
    return plans


def ran(spall, changes, ranks):
    """The same of a run, of the rank with most."""
    with tempfile.TemporaryDirectory() as folder:
        on_ranks(ranks, spall, "run", CASE, "--out", folder + "/out", *changes)
        table = tomllib.loads(pathlib.Path(folder, "out/results.toml").read_text())["communication"]
    run = {"bodies": table["imbalance"] * bodies_of(spall, changes) / ranks}
    for stage in STAGES:
        run |= {f"{stage} {what}": table[f"{stage}_{what}"] for what in COUNTS
                if f"{stage}_{what}" in table}
    if ranks <= TIMED:
        text = on_ranks(ranks, spall, "check", "--time", CASE, *changes, "--set",
                        "phases.only.duration=1s")
        steps, took = re.search(r"sample of (\d+), which took (.*?) on", text).groups()
        run["step (s)"] = seconds(took) / int(steps)
    return run


def main(spall, path, *ranks):
    ranks = [int(count) for count in ranks]
    rows = []
    for name, more in METHODS.items():
        changes = ["--set", f"phases.only.method={name.split(',')[0]}", *more]
        for count, plan in planned(spall, changes, ranks).items():
            run = ran(spall, changes, count)
            rows += [[name, count, what, f"{plan[what]:.5g}", f"{run[what]:.5g}"]
                     for what in plan if what in run and (plan[what] or run[what])]
    about = f"commit {call(HERE / 'commit.sh').strip()}"
    with open(path, "w") as file:
        file.write(f"# {about}\n")
        csv.writer(file,
                   lineterminator="\n").writerows([["method", "ranks", "what", "plan", "run"],
                                                   *rows])
    lines = [about, "", "| method | ranks | a step | plan | run |", "|---|--:|---|--:|--:|"]
    replace_section(HERE / "README.md", "plan",
                    "\n".join(lines + ["| " + " | ".join(map(str, row)) + " |" for row in rows]))


if __name__ == "__main__":
    main(*sys.argv[1:])
