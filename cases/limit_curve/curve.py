"""The ballistic limit curve of case.toml's shield: at each speed the ball's diameter from which on
the wall fails, by `spall limit`, beside five published equations.

    /usr/bin/python3 cases/limit_curve/curve.py [--speeds 3 4 5 6 7 8 9] [--jobs 2] [--table]

Searches that are done stay; a stopped one goes on. Writes the table of README.md and curve.png
(--table: only these).
SPDX-License-Identifier: BSD-3-Clause
"""
import argparse
import json
import sys
import tomllib
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

HERE = Path(__file__).parent
ROOT = HERE.parent.parent
sys.path += [str(HERE.parent), str(HERE.parent / "shields"), str(ROOT / "bench")]
from equations import EQUATIONS, Shot  # noqa: E402
from program import PROGRAM, spall  # noqa: E402
from readme import replace_section  # noqa: E402
from remnants import commits, results  # noqa: E402

CASE = HERE / "case.toml"
VOLUMES = {group["name"]: group["volume"] for group in tomllib.loads(CASE.read_text())["groups"]}


def metres(text):
    return 1e-3 * float(text.removesuffix("mm"))


BUMPER, WALL = (metres(VOLUMES[plate]["height"]) for plate in ("bumper", "wall"))
GAP = -metres(VOLUMES["wall"]["center"][2]) - WALL / 2 - BUMPER  # the bumper's front is at z = 0
CLEAR = metres(VOLUMES["ball"]["center"][2])  # of the ball's centre from the bumper
SMALLEST, LARGEST, WITHIN = 1, 4.5, "8%"  # mm
# Of the way at the ball's speed; passages of sound through the wall, at m/s, in which it bulges.
FLIGHT, RINGING, SOUND = 1.25, 50, 5350
YIELD, DENSITIES = 40, (2.785, 2.703, 2.703)  # ksi, of 6061-T6; g/cm^3: ball, bumper, wall


def shot_at(speed):
    """As the equations ask for it, at `speed` (km/s)."""
    return Shot(row=0, source="", name="", metals=("", "", ""), density=DENSITIES, diameter=0.25,
                angle=0, speed=speed, bumper=100 * BUMPER, standoff=100 * GAP, wall=100 * WALL,
                strength=YIELD, perforated=False)


def search(options, speed, folder):
    duration = (FLIGHT * GAP + CLEAR) / (1e3 * speed) + RINGING * WALL / SOUND
    spall("limit", CASE, "--out", folder, "--jobs", options.jobs, "--within", WITHIN,
          "--vary", f"groups.ball.volume.diameter={SMALLEST}..{LARGEST}mm",
          program=options.program, changes=[
              f"groups.ball.velocity=[0,0,{-1e3 * speed}]", f"phases.shot.duration={duration}",
              f"phases.shot.step={duration / 200}", f"output.series_every={duration / 10}",
              f"output.snapshot_every={duration / 4}"])


def found(folder):
    """Bracket of the diameter (mm), and how the wall fails at its upper end."""
    told = json.loads((folder / "limit.json").read_text())
    low, high = (float(told[end].removesuffix("mm")) for end in ("low", "high"))
    return low, high, told["verdict_high"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--speeds", type=float, nargs="+", default=[3, 4, 5, 6, 7, 8, 9],
                        help="km/s")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--program", type=Path, default=PROGRAM)
    parser.add_argument("--out", type=Path, default=ROOT / "out/limit_curve")
    parser.add_argument("--table", action="store_true", help="run nothing")
    options = parser.parse_args()
    lines = [f"| km/s | Spall: holds at, fails at, mm | how | {' | '.join(EQUATIONS)} |",
             f"|--:|--:|---|{'--:|' * len(EQUATIONS)}"]
    brackets, runs = [], []
    for speed in options.speeds:
        folder = options.out / f"{speed:g}"
        if not options.table:
            search(options, speed, folder)
        low, high, how = found(folder)
        brackets.append((low, high))
        runs += [run for run in folder.iterdir() if (run / "results.toml").exists()]
        critical = [10 * equation(shot_at(speed)) for equation in EQUATIONS.values()]
        lines.append(f"| {speed:g} | {low:.2f}, {high:.2f} | {how} "
                     f"| {' | '.join(f'{one:.2f}' for one in critical)} |")
        print(lines[-1], flush=True)
    worst = max(results(run)["conservation"]["energy_unexplained"] for run in runs)
    lines += ["", f"{len(runs)} runs, one seed. Energy that no entry explains: at most "
              f"{100 * worst:.2g} % of what was dissipated. Commits: {commits(runs)}."]
    replace_section(HERE / "README.md", "curve", "\n".join(lines))

    figure, axes = plt.subplots(figsize=(7, 4.2))
    fine = [options.speeds[0] + k / 20 * (options.speeds[-1] - options.speeds[0])
            for k in range(21)]
    for name, equation in EQUATIONS.items():  # some lie on the ones that they modify
        axes.plot(fine, [10 * equation(shot_at(speed)) for speed in fine], lw=1.2, label=name,
                  ls="--" if name.startswith("modified") else "-")
    middle = [(low + high) / 2 for low, high in brackets]
    axes.errorbar(options.speeds, middle, [(high - low) / 2 for low, high in brackets], fmt="o",
                  color="black", capsize=3, label="Spall: between held and failed")
    axes.set(xlabel="speed (km/s)", ylabel="critical diameter (mm)", ylim=(0, None))
    axes.legend(fontsize=8)
    figure.savefig(HERE / "curve.png", dpi=110, bbox_inches="tight")


if __name__ == "__main__":
    main()
