# Piles at several spins: what holds, beside the limit of a sphere held by its gravity and that of
# its friction.
# SPDX-License-Identifier: BSD-3-Clause
"""run.py [--only-table]: runs what is missing in out/, writes results.md and piles.png beside this
script."""
import pathlib
import sys

import h5py
import matplotlib
import numpy as np

HERE = pathlib.Path(__file__).parent
sys.path[:0] = [str(HERE.parent), str(HERE.parents[1] / "src/output")]
from remnants import (SEEDS, G, axes, clump_names, commits, largest_remnant,  # noqa: E402
                      last_frame, pile, results, run_all, scatter)
from report_figures import SKY, rock, scale_bar, show  # noqa: E402
from report_spheres import Camera, render  # noqa: E402

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

GRAIN = 2000  # kg/m^3
# Name of a body: what it is, its case, changed keys, spins as parts of its limit.
BODIES = {
    "spin": ("the pile, friction 0.5", "case.toml", [], (0.6, 0.7, 0.75, 0.8, 0.9, 1.0, 1.2)),
    "spin-rough": ("the pile, friction 1", "case.toml", ["contact.friction=1"], (0.7, 0.75, 0.8)),
    "spin-crystal": ("fcc crystal, friction 0.5", "crystal.toml", [], (0.8, 0.85, 0.9)),
    "spin-rough-crystal": ("fcc crystal, friction 1", "crystal.toml", ["contact.friction=1"],
                           (0.9,)),
}
HELD = 0.02  # change of an axis, relative, up to which a body has kept its shape


def limit(density):
    """rad/s: a body at the equator of a sphere weighs nothing, omega^2 = 4 pi G rho / 3, so
    P = sqrt(3 pi / (G rho))."""
    return np.sqrt(4 * np.pi * G * density / 3)


def frictional_limit(angle):
    """Spin of a cohesionless sphere, in units of limit(): its mean stresses across and along the
    axis are in the ratio 1 - w^2, which friction bounds by (1 - sin phi) / (1 + sin phi).
    Holsapple 2001 (Icarus 154:432); Mohr-Coulomb."""
    return np.sqrt(2 * np.sin(angle) / (1 + np.sin(angle)))


def mean_stress(x, mass, omega):
    """J, pressures times volume along the principal axes, smallest first, that hold bodies at rest
    in a frame which turns by omega about z: the tensor virial theorem, -sum m a.x of gravity and
    the centrifugal pull."""
    held = np.zeros((3, 3))
    for k in range(len(mass) - 1):
        apart = x[k + 1:] - x[k]
        pull = G * mass[k] * mass[k + 1:] / np.linalg.norm(apart, axis=1) ** 3
        held += np.einsum("k,ki,kj->ij", pull, apart, apart)
    across = x * [1, 1, 0]
    held -= omega**2 * np.einsum("k,ki,kj->ij", mass, across, across)
    return np.linalg.eigvalsh(held)


def friction_at_work(x, mass, omega):
    """rad, the friction angle that the mean stress asks for; nan: no friction holds tension."""
    stress = mean_stress(x, mass, omega)
    return np.arcsin((stress[2] - stress[0]) / (stress[2] + stress[0])) if stress[0] > 0 else np.nan


def folder_of(name, part, seed):
    return pathlib.Path(f"out/{name}-{part}-{seed}")


def seeds_of(name):
    """A crystal is the same for every seed."""
    return SEEDS if BODIES[name][1] == "case.toml" else SEEDS[:1]


def first_frame(folder):
    with h5py.File(folder / "trajectory.h5") as file:
        rows = file["particles/all"]
        return rows["position/value"][0], rows["mass"][:]


def density_of(case, seed=SEEDS[0]):
    """Bulk density, kg/m^3: of the pile by its packing fraction inside the half-mass radius, of the
    crystal by fcc's."""
    return GRAIN * (np.pi / np.sqrt(18) if case == "crystal.toml"
                    else results(pile(seed, settles=False))["pile"]["packing_fraction"])


def read(name, part, seed):
    folder, omega = folder_of(name, part, seed), limit(density_of(BODIES[name][1], seed))
    position, velocity, radius, mass = last_frame(folder)
    clump = clump_names(position, radius, 0.01)
    touching = clump == np.argmax(np.bincount(clump, mass))
    bound = largest_remnant(position, velocity, radius, mass)
    x, v = (y - np.average(y[touching], axis=0, weights=mass[touching])
            for y in (position, velocity))
    m, x, v = mass[touching], x[touching], v[touching]
    end = np.sum(m * np.cross(x, v)[:, 2]) / np.sum(m * (x[:, 0]**2 + x[:, 1]**2))
    start, whole = first_frame(folder)
    start = start - np.average(start, axis=0, weights=whole)
    before, after = axes(start, whole), axes(x, m)
    return {"name": name, "part": part, "end": end / omega,
            "lifted": 1 - m.sum() / mass.sum(), "lost": 1 - mass[bound].sum() / mass.sum(),
            "axes": after,
            "held": np.max(np.abs(after / before - 1)) < HELD and m.sum() == mass.sum(),
            "envelope": 6 * whole.sum() / (np.pi * before.prod()),
            "asked": np.degrees(friction_at_work(start, whole, part * omega)),
            "angle": np.degrees(friction_at_work(x, m, end)),
            "frame": (position, radius), "drift": results(folder)["conservation"]["angular"]}


def make_runs():
    for seed in SEEDS:
        pile(seed)
    for name, (_, case, keys, parts) in BODIES.items():
        runs = [(folder_of(name, part, seed), seed,
                 [*keys, f"groups.pile.spin=[0, 0, {part * limit(density_of(case, seed))}]"])
                for part in parts for seed in seeds_of(name)]
        run_all(f"cases/spin/{case}", runs, ["pile"] if case == "case.toml" else [])


def table(name, by_part):
    """`by_part`: rows of all seeds, a list for each spin."""
    what, case, _, _ = BODIES[name]
    every = [row for some in by_part for row in some]
    density = [density_of(case, seed) for seed in seeds_of(name)][:max(map(len, by_part))]
    period = np.mean([2 * np.pi / limit(one) / 3600 for one in density])
    lines = [f"## {what[0].upper()}{what[1:]}", "",
             f"{len(every[0]['frame'][1])} bodies; bulk density "
             f"{scatter(density) if len(density) > 1 else f'{density[0]:.0f}'} kg/m^3 (of the "
             f"ellipsoid with the same moments {np.mean([row['envelope'] for row in every]):.0f}): "
             f"P = sqrt(3 pi / (G rho)) = {period:.2f} h.", "",
             "| spin, of the limit | period, h | piles | friction that it asks for, degrees "
             "| keep their shape | spin after 6 h, of the limit | friction at work then, degrees "
             "| lifted off, of the mass | of it unbound | drift of angular momentum |",
             "|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|"]
    for some in by_part:
        column = {key: scatter([row[key] for row in some])
                  for key in ("asked", "end", "angle", "lifted", "lost")}
        lines.append(f"| {some[0]['part']} | {period / some[0]['part']:.2f} | {len(some)} "
                     f"| {column['asked']} | {sum(row['held'] for row in some)} of {len(some)} "
                     f"| {column['end']} | {column['angle']} | {column['lifted']} "
                     f"| {column['lost']} | {max(row['drift'] for row in some):.1e} |")
    moved = [some for some in by_part if not all(row["held"] for row in some)]
    if moved:
        angle = np.radians([row["angle"] for row in moved[0]])
        lines += ["", f"The first spin at which one gives way is {moved[0][0]['part']}. "
                  f"These come to {scatter([row['end'] for row in moved[0]])} of the limit with "
                  f"{scatter(np.degrees(angle))} degrees of friction at work; spheres of that "
                  f"friction have their limit at {scatter(frictional_limit(angle))}."]
    return [*lines, ""]


def main():
    if "--only-table" not in sys.argv:
        make_runs()
    made = commits(folder_of(name, part, seed) for name in BODIES for part in BODIES[name][3]
                   for seed in seeds_of(name)
                   if (folder_of(name, part, seed) / "results.toml").exists())
    lines = ["# Bodies that spin: the runs",
             f"Written by `cases/spin/run.py`, runs by commit {made}; mean ± standard deviation "
             "over piles of other seeds. A body keeps its shape if none of its axes (of the "
             f"ellipsoid with the same moments) has changed by {100 * HELD:g} % after 6 h and "
             "nothing has lifted off. The friction that a spin asks for is that of the mean stress "
             "by the tensor virial theorem: asin of (largest - smallest) / (largest + smallest) "
             "principal pressure.", ""]
    everything = []
    for name, (_, _, _, parts) in BODIES.items():
        by_part = [[read(name, part, seed) for seed in seeds_of(name)
                    if (folder_of(name, part, seed) / "results.toml").exists()]
                   for part in parts]
        by_part = [some for some in by_part if some]
        lines += table(name, by_part) if by_part else []
        everything += [some[0] for some in by_part]
    angles = (20, 25, 30, 35, 40, 50)
    lines += ["## The limit of a sphere by friction alone", "",
              "sqrt(2 sin phi / (1 + sin phi)) of sqrt(4 pi G rho / 3), Holsapple 2001.", "",
              "| friction angle, degrees | " + " | ".join(map(str, angles)) + " |",
              "|---|" + "--:|" * len(angles),
              "| spin, of the limit | "
              + " | ".join(f"{frictional_limit(np.radians(a)):.2f}" for a in angles) + " |"]
    (HERE / "results.md").write_text("\n".join(lines) + "\n")
    across = 4
    lines_of_panels = -(-len(everything) // across)
    figure, panels = plt.subplots(lines_of_panels, across,
                                  figsize=(3 * across, 2.3 * lines_of_panels),
                                  facecolor=tuple(SKY), squeeze=False)
    for panel in panels.flat[len(everything):]:
        panel.set_axis_off()
    for panel, row in zip(panels.flat, everything):
        position, radius = row["frame"]
        camera = Camera(np.array([0.3, -1, 0.35]), np.array([0, 0, 1.0]),
                        np.median(position, axis=0), 220, 165, 330)
        show(panel, camera, render(camera, position, radius, rock(len(radius)), SKY))
        panel.set_title(f"{BODIES[row['name']][0]}: {row['part']}", color="white", loc="center",
                        fontsize=9)
    scale_bar(panels[0][0], camera)
    figure.subplots_adjust(0.005, 0.005, 0.995, 0.95, wspace=0.02, hspace=0.13)
    figure.savefig(HERE / "piles.png", dpi=110, facecolor=tuple(SKY))


if __name__ == "__main__":
    main()
