"""Times the solver's kernel and puts the table into bench/README.md; a minute for each build.
usage: kernel.py BUILD_FOLDER [OTHER_BUILD_FOLDER …], for example build/release build/scalar

SPDX-License-Identifier: BSD-3-Clause
"""
import json
import pathlib
import statistics
import subprocess
import sys

from readme import origin, replace_section

ROUNDS = 5
SIZES = {30000: "30 thousand", 300000: "300 thousand", 3000000: "3 million"}
KINDS = {"float, 3, FrictionModel::coulomb": "dimension 3, exact Coulomb",
         "float, 3, FrictionModel::convex": "dimension 3, convex",
         "double, 3, FrictionModel::coulomb": "dimension 3, exact Coulomb, doubles",
         "float, 1, FrictionModel::coulomb": "dimension 1",
         "double, 1, FrictionModel::coulomb": "dimension 1, doubles"}


def measure(build):
    """Nanoseconds a contact and iteration by (kind, size), of one run."""
    out = subprocess.run([f"{build}/bench/bench_solver_kernel", "--benchmark_format=json",
                          "--benchmark_min_time=0.2"], capture_output=True, text=True, check=True)
    times = {}
    for row in json.loads(out.stdout)["benchmarks"]:
        kind, size = row["name"].removeprefix("iteration<").split(">/")
        times[kind, int(size)] = 1e9 * row["s_a_contact"]
    return times


def main(builds):
    runs = [[measure(build) for build in builds] for _ in range(ROUNDS)]
    lines = [f"{origin(1)}; medians of {ROUNDS} runs in turns (least–most).", "",
             "| build | kernel | " + " | ".join(f"{name} contacts" for name in SIZES.values())
             + " |",
             "|---|---|" + "--:|" * len(SIZES)]
    for b, build in enumerate(builds):
        for kind, name in KINDS.items():
            cells = []
            for size in SIZES:
                times = [run[b][kind, size] for run in runs]
                cells.append(f"{statistics.median(times):.1f} ({min(times):.1f}–{max(times):.1f})")
            lines.append(f"| {pathlib.Path(build).name} | {name} | " + " | ".join(cells) + " |")
    replace_section(pathlib.Path(__file__).resolve().parent / "README.md", "kernel",
                    "\n".join(lines))


if __name__ == "__main__":
    main(sys.argv[1:])
