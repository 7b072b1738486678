#!/usr/bin/python3
"""What a body-step of a solid costs beside one of pair potentials, on one scene; writes section
solid_step of README.md.

SPDX-License-Identifier: BSD-3-Clause
usage: solid_step.py [SPALL]
"""
import pathlib
import statistics
import subprocess
import sys
import tempfile
import tomllib

from readme import origin, replace_section

ROOT = pathlib.Path(__file__).resolve().parent.parent
ACROSS, DIAMETER = 16, 9.53e-3  # bodies; m
STEP, STEPS = 2e-9, 100  # s: solids bear no longer ones at 6.7 km/s
TURNS = 5


def seconds(program, method, folder):
    """(of forces alone, with searches) of the first steps of shot 4-1353."""
    spacing = DIAMETER / ACROSS
    changes = [f"groups.{group}.packing.diameter={spacing}" for group in ("plate", "ball")]
    changes += [f"groups.ball.volume.center=[0, 0, {DIAMETER / 2 + 1.05 * spacing}]",
                f"phases.impact.step={STEP}", f"phases.impact.duration={STEPS * STEP}",
                f"output.series_every={STEPS * STEP}", f"output.snapshot_every={STEPS * STEP}"]
    case = ROOT / "cases/plate_solid/case.toml"
    if method == "potential":
        changes += ["phases.impact.method=potential", "pair_potential.material=aluminium",
                    "pair_potential.damping=0.3"]
    told = subprocess.run([program, "run", case, "--out", folder, "--overwrite",
                           *[word for one in changes for word in ("--set", one)]], check=True,
                          capture_output=True, text=True).stdout
    time = tomllib.loads((folder / "results.toml").read_text())["time"]
    bodies = next(int(line.split()[0]) for line in told.splitlines() if " bodies, " in line)
    each = 1e6 / (bodies * STEPS)
    return each * time["forces_s"], each * (time["forces_s"] + time["neighbours_s"]), bodies


def main():
    program = sys.argv[1] if len(sys.argv) > 1 else ROOT / "build/release/spall"
    found = {"solid": [], "potential": []}
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(TURNS):
            for method, runs in found.items():
                runs.append(seconds(program, method, pathlib.Path(folder) / method))
    ratios = [[one[k] / other[k] for one, other in zip(found["solid"], found["potential"])]
              for k in (0, 1)]
    text = [origin(1) + f"; {found['solid'][0][2]:,} bodies, {STEPS} steps of {1e9 * STEP:g} ns, "
            f"medians of {TURNS} turns", "",
            "| us a body-step | solid | pair potentials | ratio (least to most) |",
            "|---|--:|--:|--:|"]
    for k, name in enumerate(("forces", "with searches")):
        middle = {method: statistics.median(run[k] for run in runs)
                  for method, runs in found.items()}
        text.append(f"| {name} | {middle['solid']:.2f} | {middle['potential']:.2f} "
                    f"| {statistics.median(ratios[k]):.2f} ({min(ratios[k]):.2f} to "
                    f"{max(ratios[k]):.2f}) |")
    replace_section(ROOT / "bench/README.md", "solid_step", "\n".join(text))
    print("\n".join(text))


if __name__ == "__main__":
    main()
