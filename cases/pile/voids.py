# How much of a settled pile is empty: shapes, sizes and cohesion.
# SPDX-License-Identifier: BSD-3-Clause
"""voids.py [--only-table]: runs what is missing in out/, each run on one rank, and writes the table
in README.md beside this script."""
import itertools
import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent), str(HERE.parent.parent / "bench")]
from readme import replace_section  # noqa: E402
from remnants import commits, results, run_all, scatter  # noqa: E402

SEEDS = (1, 2, 3)
AXES = "[2, 1.414, 1]"  # fragments of impacts (Fujiwara et al. 1978)
SHAPES = {
    "balls": "",
    "twins of 2 balls": "{spheres = [{at = [0, 0, 0], radius = 1}, {at = [1, 0, 0], radius = 1}]}",
    "2 : √2 : 1, of 5 balls": f"{{axes = {AXES}, count = 5}}",
    "2 : √2 : 1, of 15 balls": f"{{axes = {AXES}, count = 15}}",
    "tetrapods of 4 balls": "{spheres = ["
                            + ", ".join(f"{{at = {at}, radius = 1}}" for at in (
                                [0.6, 0.6, 0.6], [0.6, -0.6, -0.6],
                                [-0.6, 0.6, -0.6], [-0.6, -0.6, 0.6])) + "]}",
}
ALIKE = 'radius = "5 m"'  # as the case has it
SIZES = {"all alike": ALIKE,
         "1 to 4": 'sizes = {law = "power", smallest = "2 m", largest = "8 m", exponent = 3}'}
COHESIONS = (0, 30, 300)  # N; a ball of 5 m at the surface weighs some 20 N


def folder_of(shape, sizes, cohesion, seed):
    place = [list(SHAPES).index(shape), list(SIZES).index(sizes)]
    return pathlib.Path("out/voids-" + "-".join(map(str, [*place, cohesion, seed])))


def main():
    there = []
    for place, (sizes, law) in enumerate(SIZES.items()):
        runs = []
        for shape, cohesion, seed in itertools.product(SHAPES, COHESIONS, SEEDS):
            changes = [f"seed={seed}"]
            if SHAPES[shape]:
                changes += [f"shapes.one={SHAPES[shape]}", "groups.cloud.packing.shape=one"]
            if cohesion:
                changes += [f"contact.cohesion={cohesion}N", 'contact.cohesion_range="1 cm"']
            runs.append((folder_of(shape, sizes, cohesion, seed), seed, changes))
        if "--only-table" not in sys.argv:
            case = pathlib.Path(f"out/voids-{place}.toml")  # a change cannot take a radius away
            case.write_text((HERE / "case.toml").read_text().replace(ALIKE, law))
            run_all(str(case), runs, [])
        there += [folder for folder, _, _ in runs if (folder / "results.toml").exists()]
    if not there:
        return
    lines = [f"Runs by commit {commits(there)}; mean ± standard deviation over {len(SEEDS)} seeds.",
             "", "| bodies | sizes | " + " | ".join(f"{c} N" for c in COHESIONS) + " |",
             "|---|---|" + "--:|" * len(COHESIONS)]
    for shape, sizes in itertools.product(SHAPES, SIZES):
        cells = []
        for cohesion in COHESIONS:
            found = [folder_of(shape, sizes, cohesion, seed) for seed in SEEDS]
            filled = [results(folder)["pile"]["packing_fraction"]
                      for folder in found if folder in there]
            cells.append(scatter([1 - f for f in filled]) if filled else "")
        lines.append(f"| {shape} | {sizes} | " + " | ".join(cells) + " |")
    replace_section(HERE / "README.md", "voids", "\n".join(lines))


if __name__ == "__main__":
    main()
