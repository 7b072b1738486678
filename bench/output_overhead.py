"""What restart files, snapshots and kept states cost the main job: output_overhead.py SPALL
[NEVER_KEEPS] [--bodies 2000]

Turns of `didymoon` with its output, and with none but that at the ends of phases; NEVER_KEEPS is a
program that was built to keep no state. Processor time of one rank, which waits for nobody, and the
least of all turns: what else a shared machine does only adds to it. The pile has fewer bodies than
that of the main job, so that turns take seconds; the fewer, the more a file costs. Writes
bench/README.md.
SPDX-License-Identifier: BSD-3-Clause
"""
import argparse
import csv
import pathlib
import statistics
import tempfile

from readme import origin, replace_section
from timing import processor_seconds

here = pathlib.Path(__file__).resolve().parent
NONE = ["output.snapshot_every=0", "output.restart_every=1e9 s"]


def pile(bodies):
    """What makes the main job's cloud one of that many bodies."""
    radius = 95 * (bodies / 10307) ** (1 / 3)
    return [f"groups.cloud.packing.count={bodies}", f"groups.cloud.volume.radius={radius:.3f} m"]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("spall")
    parser.add_argument("never_keeps", nargs="?")
    parser.add_argument("--bodies", type=int, default=2000)
    parser.add_argument("--turns", type=int, default=9)
    given = parser.parse_args()
    kinds = {"no files but at the ends of phases": (given.spall, NONE),
             "the case's output": (given.spall, [])}
    if given.never_keeps:
        kinds["no files, and no state is kept"] = (given.never_keeps, NONE)
    seconds = {kind: [] for kind in kinds}
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(given.turns):
            for kind, (program, changes) in kinds.items():
                seconds[kind].append(processor_seconds(
                    program, here.parent / "cases/didymoon/case.toml",
                    [*pile(given.bodies), *changes], pathlib.Path(folder) / "out"))
                print(f"{kind}: {seconds[kind][-1]:.2f} s", flush=True)
    with open(here / "results/output_overhead.csv", "w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["kind", *(f"turn_{k + 1}_s" for k in range(given.turns))])
        rows.writerows([kind, *(f"{one:.3f}" for one in all_)] for kind, all_ in seconds.items())
    plain = min(seconds["no files but at the ends of phases"])
    table = [f"{origin(1)}; {given.bodies} bodies, {given.turns} turns; processor time.", "",
             "| written | least, s | median | most | least beside no files |",
             "|---|--:|--:|--:|--:|"]
    table += [f"| {kind} | {min(own):.2f} | {statistics.median(own):.2f} | {max(own):.2f} | "
              f"{100 * (min(own) / plain - 1):+.1f} % |" for kind, own in seconds.items()]
    replace_section(here / "README.md", "output", "\n".join(table))


if __name__ == "__main__":
    main()
