#!/usr/bin/env python3
# Measures the bars of the code's layout: layers, what a change of one header recompiles, lines.
# SPDX-License-Identifier: BSD-3-Clause
"""usage: bars.py [BUILD_FOLDER] [--base COMMIT] [--write]    for example bars.py build/release

1. Layers: no include runs up (tests/layers.py).
2. Recompiled: sources and objects of the library that depend on each header below, by ninja's own
   record of what the compiler read (the build must be complete). Kernels are several objects a
   source: one for each level of instructions. At most 14 objects for the settings of an engine.
   Where there are more, the headers through which they come are named, the worst first.
3. Lines: of src and include, against those of a commit with --base.

Exit code 1 where a bar is missed, or where nothing was there to be measured. Nothing is built.
--write puts the tables into docs/architecture.md.
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
SETTINGS = ["src/penalty/penalty.hpp", "src/potential/pair_potential.hpp",
            "src/potential/settings.hpp", "src/solver/settings.hpp", "src/penalty/engine.hpp",
            "src/potential/engine.hpp", "src/rigid/engine.hpp", "src/solid/engine.hpp"]
# The library's sources, and its kernels once more for other levels of instructions.
OBJECTS = re.compile(r"CMakeFiles/spall_(?:objects|v3|v4)\.dir/(src/.*\.cpp)\.o")
# Before the code was laid out in rooms, and after: that commit also brought laws by pair of
# materials, the library for programs outside, and kernels for each level of instructions.
BEFORE, MOVED = "9cf5148", "ba1910b"


def dependents(build):
    """Library object -> files of this tree that it was compiled from."""
    said = subprocess.run(["ninja", "-t", "deps"], cwd=build, check=True, capture_output=True,
                          text=True).stdout
    found = {}
    for block in said.split("\n\n"):
        lines = block.splitlines()
        if not lines or not OBJECTS.match(lines[0]):
            continue
        read = {(build / line.strip()).resolve() for line in lines[1:]}
        found[lines[0].split(":")[0]] = {str(f.relative_to(ROOT)) for f in read
                                         if f.is_relative_to(ROOT)}
    return found


def source_of(name):
    return OBJECTS.match(name)[1]


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
    through["their own source"] = sum(header in direct.get(source_of(name), [])
                                      for name, read in objects.items() if header in read)
    return ", ".join(f"{file} ({count})" for file, count in through.most_common(5))


def git(*words):
    return subprocess.run(["git", "-C", ROOT, *words], check=True, capture_output=True,
                          text=True).stdout


def count_lines(commit=None):
    if commit is None:
        files = [p for folder in ("src", "include") for p in (ROOT / folder).rglob("*.[ch]pp")]
        return sum(p.read_text().count("\n") for p in files)
    files = [f for f in git("ls-tree", "-r", "--name-only", commit, "src", "include").split()
             if f.endswith((".cpp", ".hpp"))]
    return sum(git("show", f"{commit}:{f}").count("\n") for f in files)


def write(recompiled, objects, lines):
    sys.path.insert(0, str(ROOT / "bench"))
    from readme import replace_section
    commit = subprocess.run([ROOT / "bench" / "commit.sh"], check=True, capture_output=True,
                            text=True).stdout.strip()
    sources = len({source_of(name) for name in objects})
    table = [f"Commit {commit}; the library has {sources} sources, which make {len(objects)} "
             "objects.", "", "| a change of | compiles sources | objects |", "|---|---|---|"]
    table += [f"| `{header}` | {of_sources} | {of_objects} |"
              for header, of_sources, of_objects in recompiled]
    table += ["", "| lines of `src` and `include` | commit | |", "|---|---|---|",
              f"| {count_lines(BEFORE):,} | {BEFORE} | before the rooms |",
              f"| {count_lines(MOVED):,} | {MOVED} | with the rooms, laws by pair of materials, "
              "the library, kernels by level of instructions |",
              f"| {lines:,} | {commit} | with all that came since |"]
    replace_section(ROOT / "docs" / "architecture.md", "bars", "\n".join(table))


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", nargs="?", type=Path, default=ROOT / "build" / "release")
    parser.add_argument("--base", help="commit whose lines must not be exceeded")
    parser.add_argument("--write", action="store_true", help="put the tables into the page")
    args = parser.parse_args()
    missed = subprocess.run([sys.executable, ROOT / "tests" / "layers.py", ROOT]).returncode != 0

    objects, direct = dependents(args.build), includes()
    sources = {source_of(name) for name in objects}
    print(f"\n{len(sources)} sources of the library, {len(objects)} objects; recompiled by a "
          "change of")
    there = {file for file in direct if re.fullmatch(r"src/\w+/\w+\.cpp", file)}
    if not objects or not there <= sources:
        print(f"  of {len(there)} sources {len(there - sources)} have no object: the build is not "
              "complete")
        missed = True
    recompiled = []
    for header in SETTINGS:
        of = [name for name, read in objects.items() if header in read]
        recompiled.append((header, len({source_of(name) for name in of}), len(of)))
        if not of:
            print(f"  {header}: no object is made of it")
            missed = True
            continue
        good = len(of) <= MOST_OBJECTS
        missed |= not good
        print(f"  {header}: {recompiled[-1][1]} sources, {len(of)} objects"
              + ("" if good else f", more than {MOST_OBJECTS}: through "
                 + ways(header, objects, direct)))
    lines = count_lines()
    print(f"\n{lines} lines of src and include")
    if args.base:
        base = count_lines(args.base)
        print(f"{base} at {args.base}: {lines - base:+}")
        missed |= lines >= base
    if args.write and not missed:
        write(recompiled, objects, lines)
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
