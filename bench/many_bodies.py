"""Time and memory a body from a hundred thousand bodies on: one rank, two, and two runs at once.

SPDX-License-Identifier: BSD-3-Clause
usage: many_bodies.py SPALL [--turns 3] [--methods 'nonsmooth;...'] [--steps 100] [--whole]
                     [RADIUS_IN_M ...]

A twentieth of the STEPS where contacts are solved for: each of them has many iterations. The
first step cuts the domain and finds the pairs; so few steps of smooth forces would not tell what a
step costs.

RADIUS is that of the ball of plan.toml: 0.255 has 100,000 bodies, 0.55 a million, 1.5 twenty
million. In each turn a ball is run by one rank, by two, and by two runs of one rank each that know
nothing of each other. These two have a core each and share memory, as ranks do, so what they reach
together is what a second rank can bring on this machine. With --whole two ranks alone, which then
have all the memory. Writes bench/README.md.
"""
import argparse
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time
import tomllib

from compare_plan import CASE, METHODS, bodies_of
from readme import origin, replace_section

HERE = pathlib.Path(__file__).resolve().parent
STAGES = ("gravity", "neighbours", "contacts", "solver", "forces", "motion")
RADII = ("0.255", "0.55")
SMALL = "0.02"  # m: what the program takes before bodies count


class Run:
    """`spall run` of a ball, under way."""

    def __init__(self, folder, ranks, changes, cores, spall):
        self.folder = folder
        self.begin = time.monotonic()
        launch = ["mpirun", "-n", str(ranks)] if ranks > 1 else ["taskset", "-c", cores]
        self.process = subprocess.Popen(
            [*launch, spall, "run", CASE, "--out", folder, "--overwrite", *changes],
            stdout=subprocess.DEVNULL)

    def end(self, steps):
        """Seconds of a step, seconds of all else, and the most bytes of one rank."""
        _, status, used = os.wait4(self.process.pid, 0)
        whole = time.monotonic() - self.begin
        if status != 0:
            sys.exit(f"{self.folder}: {status}")
        spent = tomllib.loads(pathlib.Path(self.folder, "results.toml").read_text())["time"]
        stepping = sum(spent.get(f"{stage}_s", 0) for stage in STAGES)
        return stepping / steps, whole - stepping, 1024 * used.ru_maxrss


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("spall")
    parser.add_argument("--turns", type=int, default=3)
    parser.add_argument("--methods", default=";".join(METHODS), help="separated by ;")
    parser.add_argument("--steps", type=int, default=100)
    parser.add_argument("--whole", action="store_true", help="two ranks alone")
    parser.add_argument("radii", nargs="*", default=RADII)
    given = parser.parse_intermixed_args()
    kept = tempfile.TemporaryDirectory()
    folder = kept.name

    def steps_of(name):
        return given.steps // 20 if name.startswith("nonsmooth") else given.steps

    def run(name, radius, ranks, cores="0", at="one"):
        changes = [f"phases.only.method={name.split(',')[0]}",
                   f"groups.ball.volume.radius={radius}m",
                   f"phases.only.duration={steps_of(name)} us", "output.snapshot_every=0",
                   "output.series_every=1 s"]  # a row of each step costs as much as the step
        words = [word for change in changes for word in ("--set", change)] + METHODS[name]
        return Run(f"{folder}/{at}", ranks, words, cores, given.spall), words

    lines = []
    for name in given.methods.split(";"):
        steps = steps_of(name)
        empty = {ranks: run(name, SMALL, ranks)[0].end(steps)[2] for ranks in (1, 2)}
        for radius in given.radii:
            taken = {ranks: [] for ranks in ((2,) if given.whole else (1, 2))}
            shared = []
            for _ in range(given.turns):
                for ranks, ends in taken.items():
                    one, words = run(name, radius, ranks)
                    ends.append(one.end(steps))
                if given.whole:
                    continue
                pair = [run(name, radius, 1, str(core), f"beside_{core}")[0] for core in (0, 1)]
                shared.append(statistics.mean(other.end(steps)[0] for other in pair))
            bodies = bodies_of(given.spall, words)
            speed_up = [a[0] / b[0] for a, b in zip(taken.get(1, []), taken[2])]
            beside = [both / (2 * b[0]) for both, b in zip(shared, taken[2])]
            for ranks, rows in taken.items():
                step, rest, most = (statistics.median(column) for column in zip(*rows))
                row = [name, f"{bodies:,}", ranks, f"{1e9 * step / bodies:.0f}",
                       f"{1e9 * rest / bodies:.0f}",
                       f"{ranks * (most - empty[ranks]) / bodies:.0f}"]
                row += [f"{statistics.median(speed_up):.2f}",
                        f"{statistics.median(beside):.2f} ({min(beside):.2f}–{max(beside):.2f})",
                        ] if ranks > 1 and beside else ["", ""]
                lines.append("| " + " | ".join(map(str, row)) + " |")
                print(lines[-1], flush=True)
    head = [f"{origin(2)}; medians of {given.turns} turns of "
            f"{given.steps} steps, a twentieth where contacts are solved for.", "",
            "| method | bodies | ranks | a body and step, ns | all else, ns a body | bytes a body "
            "| speed-up | beside two runs at once |", "|---|--:|--:|--:|--:|--:|--:|--:|"]
    replace_section(HERE / "README.md", "most bodies" if given.whole else "many bodies",
                    "\n".join(head + lines))


if __name__ == "__main__":
    main()
