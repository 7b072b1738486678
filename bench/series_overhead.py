"""What the rows of the series cost a packing of grains.

usage: series_overhead.py SPALL [--turns 9] [--duration "20 ms"]

Turns of `column` with the series as it is by default, and with a row at the ends of phases alone;
no other files. Processor time of one rank, which waits for nobody; ratios of one turn. Writes
bench/README.md.
SPDX-License-Identifier: BSD-3-Clause
"""
import argparse
import pathlib
import statistics
import tempfile

from readme import origin, replace_section
from timing import processor_seconds

here = pathlib.Path(__file__).resolve().parent
NO_FILES = ["output.snapshot_every=0", "output.restart_every=1e9 s"]
KINDS = {"as it is": [], "no rows": ["output.series_every=1e9 s"]}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("spall")
    parser.add_argument("--turns", type=int, default=9)
    parser.add_argument("--duration", default="20 ms")
    given = parser.parse_args()
    duration = f"phases.collapse.duration={given.duration}"
    ratios = []
    with tempfile.TemporaryDirectory() as folder:
        lines = (here.parent / "cases/column/case.toml").read_text().split("\n")
        (pathlib.Path(folder) / "case.toml").write_text(
            "\n".join(line for line in lines if not line.startswith("series_every")))
        for turn in range(given.turns):
            # Each goes first in turn: what the machine does meanwhile falls on both.
            order = list(KINDS)[:: 1 if turn % 2 else -1]
            seconds = {kind: processor_seconds(given.spall, pathlib.Path(folder) / "case.toml",
                                               [*NO_FILES, duration, *KINDS[kind]],
                                               pathlib.Path(folder) / "out")
                       for kind in order}
            ratios.append(seconds["as it is"] / seconds["no rows"] - 1)
            print(f"{seconds['as it is']:.2f} s as it is, {seconds['no rows']:.2f} s without rows: "
                  f"{100 * ratios[-1]:+.1f} %", flush=True)
        rows = len((pathlib.Path(folder) / "out/series.csv").read_text().splitlines()) - 1
    text = (f"{origin(1)}; {given.turns} turns of {given.duration}: the default rows add "
            f"{100 * statistics.median(ratios):+.1f} % "
            f"({100 * min(ratios):+.1f} to {100 * max(ratios):+.1f} %) "
            f"to the processor time of a run")
    print(text, rows)
    replace_section(here / "README.md", "series", text + ".")


if __name__ == "__main__":
    main()
