#!/usr/bin/env python3
# Measures the bars of the code's layout: layers, what a change of one header recompiles, lines.
# SPDX-License-Identifier: BSD-3-Clause
"""usage: bars.py [BUILD_FOLDER] [--base COMMIT]    for example bars.py build/release

1. Layers: no include runs up (tests/layers.py).
2. Recompiled: objects of the library that depend on each header below, by ninja's own record of
   what the compiler read (the build must be complete). At most 14 for the settings of an engine.
   Where there are more, the headers through which they come are named, the worst first.
3. Lines: of src and include, against those of a commit with --base.

Exit code 1 where a bar is missed. Nothing is built or changed.
"""
import argparse
import re
import subprocess
import sys
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
MOST_OBJECTS = 14
# What an engine is set by: a changed default must not concern the others.
SETTINGS = ["src/penalty/penalty.hpp", "src/potential/pair_potential.hpp", "src/solver/problem.hpp",
            "src/penalty/engine.hpp", "src/potential/engine.hpp", "src/rigid/engine.hpp"]


def dependents(build):
    """Library object -> files of this tree that it was compiled from."""
    said = subprocess.run(["ninja", "-t", "deps"], cwd=build, check=True, capture_output=True,
                          text=True).stdout
    found = {}
    for block in said.split("\n\n"):
        lines = block.splitlines()
        if not lines or not lines[0].startswith("CMakeFiles/spall_core.dir/"):
            continue
        read = {(build / line.strip()).resolve() for line in lines[1:]}
        found[lines[0].split(":")[0]] = {str(f.relative_to(ROOT)) for f in read
                                         if f.is_relative_to(ROOT)}
    return found


def includes():
    """File -> files of the tree that it includes itself."""
    direct = {}
    for folder in ("src", "include"):
        for path in (ROOT / folder).rglob("*.[ch]pp"):
            named = re.findall(r'^#include "([^"]+)"', path.read_text(), re.M)
            direct[str(path.relative_to(ROOT))] = [
                f"{'include' if name.startswith('spall/') else 'src'}/{name}" for name in named]
    return direct


def ways(header, objects, direct):
    """Through which headers sources come to this one: how many objects include each of them."""
    through = Counter()
    for file, named in direct.items():
        if header in named and file.endswith(".hpp"):
            through[file] = sum(file in read for read in objects.values())
    through["their own source"] = sum(header in direct.get(f"src/{name.split('/src/')[1][:-2]}", [])
                                      for name, read in objects.items() if header in read)
    return ", ".join(f"{file} ({count})" for file, count in through.most_common(5))


def count_lines(commit=None):
    if commit is None:
        files = [p for folder in ("src", "include") for p in (ROOT / folder).rglob("*.[ch]pp")]
        return sum(p.read_text().count("\n") for p in files)

    def git(*words):
        return subprocess.run(["git", "-C", ROOT, *words], check=True, capture_output=True,
                              text=True).stdout
    files = [f for f in git("ls-tree", "-r", "--name-only", commit, "src", "include").split()
             if f.endswith((".cpp", ".hpp"))]
    return sum(git("show", f"{commit}:{f}").count("\n") for f in files)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", nargs="?", type=Path, default=ROOT / "build" / "release")
    parser.add_argument("--base", help="commit whose lines must not be exceeded")
    args = parser.parse_args()
    missed = subprocess.run([sys.executable, ROOT / "tests" / "layers.py", ROOT]).returncode != 0

    objects, direct = dependents(args.build), includes()
    print(f"\n{len(objects)} library objects; recompiled by a change of")
    for header in SETTINGS:
        if header not in direct:
            print(f"  {header}: is not there")
            missed = True
            continue
        count = sum(header in read for read in objects.values())
        good = count <= MOST_OBJECTS
        missed |= not good
        print(f"  {header}: {count}" + ("" if good else f", more than {MOST_OBJECTS}: through "
                                        + ways(header, objects, direct)))
    lines = count_lines()
    print(f"\n{lines} lines of src and include")
    if args.base:
        base = count_lines(args.base)
        print(f"{base} at {args.base}: {lines - base:+}")
        missed |= lines >= base
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
