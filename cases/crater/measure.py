"""Makes craters in three thick targets, and puts their depths and widths beside formulas.

    /usr/bin/python3 cases/crater/measure.py [--targets aluminium_6061_t6 fused_silica]
    [--across 4 6] [--seeds 1 2 3]          prints a table

Each run is case.toml with other sizes and another target. The last run of each target is drawn in
craters.png.
SPDX-License-Identifier: BSD-3-Clause
"""
import argparse
import sys
import time
import tomllib
from dataclasses import dataclass
from pathlib import Path

import h5py
import matplotlib
import numpy as np

HERE = Path(__file__).parent
sys.path.append(str(HERE.parent))
from cour_palais import crater_depth  # noqa: E402
from program import PROGRAM, ROOT, spall  # noqa: E402

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

SPEED, BALL_DENSITY = 7.0, 2.703  # km/s, g/cm^3
STILL = 0.01  # of the ball's speed: what rises faster has left


@dataclass
class Target:
    ball: float  # mm, diameter
    wide: float  # balls, diameter of the block
    deep: float  # balls
    until: float  # us
    depth: float  # mm, by formula
    glass: bool = False  # its crater is no hemisphere

    @property
    def width(self):
        """mm, by formula."""
        return 2 * self.depth


def metal(hardness, density):
    """mm, of a ball of 6.35 mm."""
    return crater_depth(6.35, SPEED, hardness, BALL_DENSITY / density)


def glass(diameter):
    """mm. Cour-Palais's depth in fused silica, as NASA/TM-2009-214785 has it (6-8)."""
    return 10 * 0.53 * (diameter / 10)**1.06 * BALL_DENSITY**0.5 * SPEED**(2 / 3)


# Brinell's hardness: 95 of 6061-T6, 23 of 1100-O, usual handbook values.
TARGETS = {
    "aluminium_6061_t6": Target(6.35, 10, 6.3, 24, metal(95, 2.703)),
    "aluminium_1100_o": Target(6.35, 13, 8, 40, metal(23, 2.707)),
    "fused_silica": Target(1, 14, 7, 12, glass(1), glass=True),
}


def changes(name, across, seed):
    target = TARGETS[name]
    ball, spacing = 1e-3 * target.ball, 1e-3 * target.ball / across
    deep, until = target.deep * ball, 1e-6 * target.until
    return [f"seed={seed}", f'materials.target.library="{name}"',
            f"groups.ball.volume.diameter={ball}", f"groups.ball.packing.diameter={spacing}",
            f"groups.ball.volume.center=[0, 0, {ball / 2 + 1.05 * spacing}]",
            f"groups.block.volume.diameter={target.wide * ball}",
            f"groups.block.volume.height={deep}", f"groups.block.packing.diameter={spacing}",
            f"groups.block.volume.center=[0, 0, {-deep / 2}]",
            f"phases.impact.step={until / 100}", f"phases.impact.duration={until}",
            f"output.series_every={until / 40}", f"output.snapshot_every={until / 4}"]


def main_piece(position, spacing):
    """Which bodies hang together with the middle of the lowest layers: by cells side by side that
    are filled."""
    cells = np.floor((position - position.min(axis=0)) / (1.2 * spacing)).astype(int) + 1
    filled = np.zeros(cells.max(axis=0) + 2, dtype=bool)
    filled[tuple(cells.T)] = True
    reached = np.zeros_like(filled)
    low = np.quantile(position[:, 2], 0.1)
    reached[tuple(cells[np.argmin(np.linalg.norm(position - [0, 0, low], axis=1))])] = True
    while True:
        wider = reached
        for axis in range(3):
            wider = wider | np.roll(wider, 1, axis) | np.roll(wider, -1, axis)
        wider &= filled
        if np.array_equal(wider, reached):
            return reached[tuple(cells.T)]
        reached = wider


def crater(start, position, velocity, spacing, radius):
    """m: depth in the deepest ring around the axis, rings being two spacings wide; width in the two
    spacings below the old surface, the median of sixteen sectors. The surface is where it was, but
    for what the block has moved far from the axis."""
    from_axis = np.hypot(start[:, 0], start[:, 1])
    far = (from_axis > 0.85 * radius) & (start[:, 2] > -0.3 * radius)
    surface = np.median((position - start)[far, 2]) + start[:, 2].max()
    stays = velocity[:, 2] - np.mean(velocity[:, 2]) < STILL * 1e3 * SPEED
    position = position[stays & (np.abs(position) < 1.5 * radius).all(axis=1)]
    position = position[main_piece(position, spacing)]
    height, from_axis = position[:, 2] - surface, np.hypot(position[:, 0], position[:, 1])
    rings = np.floor(from_axis / (2 * spacing)).astype(int)
    depth = -min(height[rings == k].max() for k in range(int(0.25 * radius / spacing)))
    sectors = np.floor(np.arctan2(position[:, 1], position[:, 0]) / (2 * np.pi) * 16).astype(int)
    near = (height > -2 * spacing) & (height < 0)
    edges = [from_axis[near & (sectors == k)].min() for k in range(-8, 8)]
    return depth, 2 * np.median(edges)


def draw(folders):
    """Sections through craters: plastic strain of metals, damage of glass."""
    figure, axes = plt.subplots(1, len(folders), figsize=(5 * len(folders), 3.6),
                                layout="constrained", squeeze=False)
    for (name, folder), axis in zip(folders.items(), axes[0]):
        target = TARGETS[name]
        with h5py.File(folder / "trajectory.h5") as file:
            bodies = file["particles/all"]
            x = 1e3 * bodies["position/value"][-1]
            colour = bodies["damage/value" if target.glass else "plastic_strain/value"][-1]
            cut = np.abs(x[:, 1]) < 2e3 * bodies["radius"][:]
        drawn = axis.scatter(x[cut, 0], x[cut, 2], c=colour[cut], s=3, cmap="viridis", vmin=0,
                             vmax=1)
        figure.colorbar(drawn, label="damage" if target.glass else "plastic strain")
        wide = 0.5 * target.ball * target.wide
        axis.set(aspect="equal", title=name, xlabel="x (mm)", ylabel="z (mm)", xlim=(-wide, wide),
                 ylim=(-target.ball * target.deep, 0.6 * wide))
    figure.savefig(HERE / "craters.png", dpi=75)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--targets", nargs="+", choices=TARGETS, default=list(TARGETS))
    parser.add_argument("--across", type=int, nargs="+", default=[4, 6])
    parser.add_argument("--seeds", type=int, nargs="+", default=[1])
    parser.add_argument("--program", default=PROGRAM)
    parser.add_argument("--before", default="", help='put before the program, such as "nice -n 5"')
    parser.add_argument("--out", type=Path, default=ROOT / "out/crater")
    options = parser.parse_args()
    print("| target | across | seed | bodies | depth, mm | in the last quarter | formula | off | "
          "width, mm | formula | off | energy | minutes | commit |\n"
          "|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|---|")
    drawn = {}
    for name in options.targets:
        target = TARGETS[name]
        for across in options.across:
            for seed in options.seeds:
                drawn[name] = folder = options.out / f"{name}-{across}-{seed}"
                begun = time.time()
                spall("run", HERE / "case.toml", "--out", folder, "--overwrite",
                      changes=changes(name, across, seed), program=options.program,
                      before=options.before.split())
                show(name, target, across, seed, folder, time.time() - begun)
    draw(drawn)


def show(name, target, across, seed, folder, seconds):
    spacing = 1e-3 * target.ball / across
    with h5py.File(folder / "trajectory.h5") as file:
        bodies = file["particles/all"]
        block = bodies["group"][:] == 0
        start, radius = bodies["position/value"][0][block], 0.5e-3 * target.ball * target.wide
        before, after = (crater(start, bodies["position/value"][k][block],
                                bodies["velocity/value"][k][block], spacing, radius)
                         for k in (-2, -1))
    results = tomllib.loads((folder / "results.toml").read_text())
    depth, width = 1e3 * after[0], 1e3 * after[1]
    grown = 100 * (after[0] / before[0] - 1)
    wide = ("| |" if target.glass else
            f"{width:.1f} | {target.width:.1f} | {100 * (width / target.width - 1):+.0f} %")
    print(f"| {name} | {across} | {seed} | {len(block)} | {depth:.2f} | {grown:+.0f} % "
          f"| {target.depth:.2f} | {100 * (depth / target.depth - 1):+.0f} % | {wide} "
          f"| {100 * results['conservation']['energy_unexplained']:.2f} % | {seconds / 60:.1f} "
          f"| {results['provenance']['commit']} |", flush=True)


if __name__ == "__main__":
    main()
