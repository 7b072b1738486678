# Piles at several spins: what holds, beside the limit of a sphere held by its gravity and that of
# its friction.
# SPDX-License-Identifier: BSD-3-Clause
"""run.py [--only-table]: runs what is missing in out/, writes results.md and piles.png beside this
script."""
import pathlib
import subprocess
import sys

import h5py
import matplotlib
import numpy as np

HERE = pathlib.Path(__file__).parent
sys.path[:0] = [str(HERE.parent), str(HERE.parents[1] / "src/output")]
from remnants import G, axes, clump_names, largest_remnant, last_frame, results  # noqa: E402
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
    """rad/s: a body at the equator of a sphere weighs nothing, omega^2 = 4 pi G rho / 3, so P =
    sqrt(3 pi / (G rho))."""
    return np.sqrt(4 * np.pi * G * density / 3)


def frictional_limit(angle):
    """Spin of a cohesionless sphere, in units of limit(): its mean stresses across and along the
    axis are in the ratio 1 - w^2, which friction bounds by (1 - sin phi) / (1 + sin phi). Holsapple
    2001 (Icarus 154:432); Mohr-Coulomb."""
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


def folder_of(name, part):
    return pathlib.Path(f"out/{name}-{part}")


def first_frame(folder):
    with h5py.File(folder / "trajectory.h5") as file:
        rows = file["particles/all"]
        return rows["position/value"][0], rows["mass"][:]


def density_of(case):
    """Bulk density, kg/m^3: of the pile by its packing fraction inside the half-mass radius, of the
    crystal by fcc's."""
    return GRAIN * (np.pi / np.sqrt(18) if case == "crystal.toml"
                    else results(pathlib.Path("out/pile"))["pile"]["packing_fraction"])


def read(name, part, omega):
    folder = folder_of(name, part)
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
    return {"name": name, "part": part, "end": end / omega, "lifted": 1 - m.sum() / mass.sum(),
            "lost": 1 - mass[bound].sum() / mass.sum(),
            "axes": after,
            "held": np.max(np.abs(after / before - 1)) < HELD and m.sum() == mass.sum(),
            "envelope": 6 * whole.sum() / (np.pi * before.prod()),
            "asked": np.degrees(friction_at_work(start, whole, part * omega)),
            "angle": np.degrees(friction_at_work(x, m, end)),
            "frame": (position, radius), "drift": results(folder)["conservation"]["angular"]}


def run_all():
    for name, (_, case, keys, parts) in BODIES.items():
        for part in parts:
            if not (folder_of(name, part) / "results.toml").exists():
                sets = [word
                        for key in [*keys,
                                    f"groups.pile.spin=[0, 0, {part * limit(density_of(case))}]"]
                        for word in ("--set", key)]
                subprocess.run(["mpirun", "-n", "2", "build/release/spall", "run",
                                f"cases/spin/{case}", "--out", str(folder_of(name, part)),
                                *sets], check=True)


def table(name, rows):
    what, case, _, _ = BODIES[name]
    density, kept = density_of(case), [row["part"] for row in rows if row["held"]]
    moved = [row for row in rows if not row["held"]]
    lines = [f"## {what[0].upper()}{what[1:]}", "",
             f"{len(rows[0]['frame'][1])} bodies; bulk density {density:.0f} kg/m^3 (of the "
             f"ellipsoid with the same moments {rows[0]['envelope']:.0f}): "
             f"P = sqrt(3 pi / (G rho)) = {2 * np.pi / limit(density) / 3600:.3f} h.", "",
             "| spin, of the limit | period, h | friction that it asks for, degrees | keeps its "
             "shape | spin after 6 h, of the limit | friction at work then, degrees | "
             "lifted off, of the mass | of it unbound | axes of what touches, m | drift of angular "
             "momentum |", "|--:|--:|--:|---|--:|--:|--:|--:|--:|--:|"]
    for row in rows:
        lines.append(f"| {row['part']} | {2 * np.pi / limit(density) / row['part'] / 3600:.3f} | "
                     f"{row['asked']:.1f} | {'yes' if row['held'] else 'no'} | "
                     f"{row['end']:.3f} | {row['angle']:.1f} | {row['lifted']:.3f} | "
                     f"{row['lost']:.3f} | "
                     + ", ".join(f"{a:.0f}" for a in row["axes"]) + f" | {row['drift']:.1e} |")
    lines += ["",
              (f"It keeps its shape at {max(kept)} of the limit" if kept
               else "It keeps its shape at none of these")
              + (f" and gives way at {moved[0]['part']}." if moved else ".")]
    if moved:
        angle = np.radians(moved[0]["angle"])
        lines[-1] += (f" What has just given way has come to {moved[0]['end']:.3f} of the limit "
                      f"with {moved[0]['angle']:.1f} degrees of friction at work; a sphere of "
                      f"that friction has its limit at {frictional_limit(angle):.3f}.")
    return [*lines, ""]


def main():
    if "--only-table" not in sys.argv:
        run_all()
    lines = ["# Bodies that spin: the runs",
             "Written by `cases/spin/run.py`. A body keeps its shape if none of its axes (of the "
             "ellipsoid with the same "
             f"moments) has changed by {100 * HELD:g} % after 6 h and nothing has lifted off. The "
             f"friction that a spin asks for is that of "
             "the mean stress by the tensor virial theorem: asin of (largest - smallest) / "
             "(largest + smallest) principal pressure.", ""]
    everything = []
    for name, (_, case, _, parts) in BODIES.items():
        omega = limit(density_of(case))
        rows = [read(name, part, omega) for part in parts
                if (folder_of(name, part) / "results.toml").exists()]
        lines += table(name, rows) if rows else []
        everything += rows
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
                                  figsize=(3 * across, 2.3 * lines_of_panels), facecolor=tuple(SKY),
                                  squeeze=False)
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
