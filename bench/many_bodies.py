"""Time and memory a body from a hundred thousand bodies on: one rank, more, and as many runs.

SPDX-License-Identifier: BSD-3-Clause
usage: many_bodies.py SPALL [--turns 3] [--methods 'nonsmooth;...'] [--steps 100] [--ranks 2]
                     [--iterations N] [--whole] [RADIUS_IN_M ...]

A twentieth of the STEPS where contacts are solved for: each of them has many iterations, or as
many as are given. The first step cuts the domain and finds the pairs; so few steps of smooth forces
would not tell what a step costs.

RADIUS is that of the ball of plan.toml: 0.255 has 100,000 bodies, 0.55 a million, 1.5 twenty
million. In each turn a ball is run by one rank, by each of RANKS (as in 2,4,16), and by as many
runs of one rank each as the last of these, which know nothing of each other. They have a core each
and share memory, as ranks do, so what they reach together is what more ranks can bring on this
machine. With --whole the last number of ranks alone, which then has all the memory. Two ranks are
written into bench/README.md, others are printed alone.
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
        """Seconds of a step, of all else, of solving over its products, most bytes of a rank."""
        _, status, used = os.wait4(self.process.pid, 0)
        whole = time.monotonic() - self.begin
        if status != 0:
            sys.exit(f"{self.folder}: {status}")
        results = tomllib.loads(pathlib.Path(self.folder, "results.toml").read_text())
        spent = results["time"]
        stepping = sum(spent.get(f"{stage}_s", 0) for stage in STAGES)
        products = results.get("solver", {}).get("products", 0)
        product = spent["solver_s"] / products if products else 0
        return stepping / steps, whole - stepping, product, 1024 * used.ru_maxrss


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("spall")
    parser.add_argument("--turns", type=int, default=3)
    parser.add_argument("--methods", default=";".join(METHODS), help="separated by ;")
    parser.add_argument("--steps", type=int, default=100)
    parser.add_argument("--ranks", default="2", help="more than one, separated by commas")
    parser.add_argument("--iterations", help="most of a step's solve")
    parser.add_argument("--whole", action="store_true", help="the last number of ranks alone")
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
        if given.iterations:
            changes.append(f"solver.max_iterations={given.iterations}")
        words = [word for change in changes for word in ("--set", change)] + METHODS[name]
        return Run(f"{folder}/{at}", ranks, words, cores, given.spall), words

    ranks = [int(count) for count in given.ranks.split(",")]
    most = ranks[-1]
    counts = [most] if given.whole else [1, *ranks]
    lines = []
    for name in given.methods.split(";"):
        steps = steps_of(name)
        empty = {count: run(name, SMALL, count)[0].end(steps)[-1] for count in counts}
        for radius in given.radii:
            taken = {count: [] for count in counts}
            shared = []
            for _ in range(given.turns):
                for count, ends in taken.items():
                    one, words = run(name, radius, count)
                    ends.append(one.end(steps))
                if given.whole:
                    continue
                others = [run(name, radius, 1, str(core), f"beside_{core}")[0]
                          for core in range(most)]
                shared.append(statistics.mean(other.end(steps)[0] for other in others))
            bodies = bodies_of(given.spall, words)
            for count, rows in taken.items():
                step, rest, product, memory = (statistics.median(column) for column in zip(*rows))
                row = [name, f"{bodies:,}", count, f"{1e9 * step / bodies:.0f}",
                       f"{1e9 * product / bodies:.0f}" if product else "",
                       f"{1e9 * rest / bodies:.0f}",
                       f"{count * (memory - empty[count]) / bodies:.0f}"]
                more = ["", ""]
                if count > 1 and not given.whole:
                    faster = [one[0] / end[0] for one, end in zip(taken[1], rows)]
                    more[0] = f"{statistics.median(faster):.2f}"
                if count == most and shared:
                    beside = [each / (most * end[0]) for each, end in zip(shared, rows)]
                    more[1] = (f"{statistics.median(beside):.2f} "
                               f"({min(beside):.2f}–{max(beside):.2f})")
                lines.append("| " + " | ".join(map(str, row + more)) + " |")
                print(lines[-1], flush=True)
    head = [f"{origin(most)}; medians of {given.turns} turns of {given.steps} steps, "
            "a twentieth where contacts are solved for.", "",
            "| method | bodies | ranks | a body and step, ns | solving over products, ns a body "
            "| all else, ns a body | bytes a body | speed-up | beside as many runs at once |",
            "|---|--:|--:|--:|--:|--:|--:|--:|--:|"]
    if ranks == [2]:
        section = "most bodies" if given.whole else "many bodies"
        replace_section(HERE / "README.md", section, "\n".join(head + lines))


if __name__ == "__main__":
    main()
