#!/usr/bin/env python3
# What the program and its libraries take in memory, before bodies count: by where they come from.
# SPDX-License-Identifier: BSD-3-Clause
"""usage: program_memory.py SPALL [RANKS]    prints a table for bench/README.md, of the last
rank."""
import os
import re
import subprocess
import sys
import tempfile
import time
from collections import Counter, defaultdict
from pathlib import Path

CASE = """materials.rock.density = 1600
[[groups]]
name = "cloud"
material = "rock"
volume = {radius = 10}
packing = {kind = "random", radius = 1, count = 100}
[[phases]]
name = "rest"
step = "1 ms"
duration = "1e6 s"
"""
MPI_OPTIONS = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}


def libraries(file):
    """Real paths of all shared libraries that the file needs."""
    text = subprocess.run(["ldd", file], capture_output=True, text=True, check=True).stdout
    return {os.path.realpath(path) for path in re.findall(r"(/\S+) \(0x", text)}


def memory(process):
    """kB by file: all that is resident, and what no other process shares."""
    by_file = defaultdict(Counter)
    file = ""
    for line in Path(f"/proc/{process}/smaps").read_text().splitlines():
        words = line.split()
        if re.match(r"[0-9a-f]+-[0-9a-f]+ ", line):
            file = words[5] if len(words) > 5 else "anonymous"
        elif words[0] == "Rss:":
            by_file[file]["resident"] += int(words[1])
        elif words[0].startswith("Private_"):
            by_file[file]["own"] += int(words[1])
    return by_file


def ranks_below(process):
    return [int(p) for p in Path(f"/proc/{process}/task/{process}/children").read_text().split()]


def main(program, ranks):
    program = os.path.realpath(program)
    direct = {Path(path).name.split(".so")[0]: path for path in libraries(program)}
    seen, origin = set(), {}
    for name, stem in (("MPI", "libmpi"), ("HDF5", "libhdf5_openmpi"), ("PETSc", "libpetsc_real")):
        brought = (libraries(direct[stem]) | {direct[stem]}) - seen
        origin.update(dict.fromkeys(brought, f"{name} and what it brings"))
        seen |= brought
    with tempfile.TemporaryDirectory() as folder:
        case = Path(folder) / "tiny.toml"
        case.write_text(CASE)
        run = subprocess.Popen(["mpirun", "--oversubscribe", "-n", str(ranks), program, "run", case,
                                "--out", f"{folder}/out"], env=os.environ | MPI_OPTIONS,
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        time.sleep(8)  # steps are being made
        by_file = memory(ranks_below(run.pid)[-1])
        run.terminate()
        run.wait()
    table, count = defaultdict(Counter), Counter(origin.values())
    for file, kb in by_file.items():
        table[origin.get(file, "Spall, its heap and others")].update(kb)
    print("| from | libraries | resident MB | a rank's own MB |\n|---|---|---|---|")
    for name, kb in sorted(table.items()):
        print(f"| {name} | {count[name] or ''} | {kb['resident'] / 1e3:.1f} | "
              f"{kb['own'] / 1e3:.1f} |")
    total = sum(table.values(), Counter())
    print(f"| all, on {ranks} | | {total['resident'] / 1e3:.1f} | {total['own'] / 1e3:.1f} |")


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 1)
