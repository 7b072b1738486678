# A pile at several spins: what lifts off, beside the limit of a sphere held by its gravity.
# SPDX-License-Identifier: BSD-3-Clause
"""run.py [--only-table]: runs what is missing in out/, writes results.md and piles.png beside this script."""
import pathlib
import subprocess
import sys

import matplotlib
import numpy as np

HERE = pathlib.Path(__file__).parent
sys.path[:0] = [str(HERE.parent), str(HERE.parents[1] / "src/output")]
from remnants import G, axes, clump_names, largest_remnant, last_frame, results  # noqa: E402
from report_figures import SKY, rock, scale_bar, show  # noqa: E402
from report_spheres import Camera, render  # noqa: E402

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

PARTS = (0.8, 0.9, 1.0, 1.1, 1.2)  # of the limit


def limit():
    """rad/s and the bulk density, kg/m^3: omega^2 = 4 pi G rho / 3, so P = sqrt(3 pi / (G rho))."""
    density = 2000 * results(pathlib.Path("out/pile"))["pile"]["packing_fraction"]
    return np.sqrt(4 * np.pi * G * density / 3), density


def read(part):
    folder = pathlib.Path(f"out/spin-{part}")
    position, velocity, radius, mass = last_frame(folder)
    name = clump_names(position, radius, 0.01)
    touching = name == np.argmax(np.bincount(name, mass))
    bound = largest_remnant(position, velocity, radius, mass)
    x, v = (y - np.average(y[touching], axis=0, weights=mass[touching]) for y in (position, velocity))
    m, x, v = mass[touching], x[touching], v[touching]
    end = np.sum(m * np.cross(x, v)[:, 2]) / np.sum(m * (x[:, 0]**2 + x[:, 1]**2))
    return {"part": part, "end": end, "lifted": 1 - mass[touching].sum() / mass.sum(), "lost": 1 - mass[bound].sum() / mass.sum(),
            "axes": axes(position[touching], mass[touching]), "frame": (position, radius), "drift": results(folder)["conservation"]["angular"]}


def main():
    omega, density = limit()
    for part in PARTS:
        if "--only-table" not in sys.argv and not pathlib.Path(f"out/spin-{part}/results.toml").exists():
            subprocess.run(["mpirun", "-n", "2", "build/release/spall", "run", "cases/spin/case.toml", "--out", f"out/spin-{part}", "--set",
                            f"groups.pile.spin=[0, 0, {part * omega}]"], check=True)
    rows = [read(part) for part in PARTS if pathlib.Path(f"out/spin-{part}/results.toml").exists()]
    lines = ["# A pile that spins: the runs", "Written by `cases/spin/run.py`.", "",
             f"Bulk density {density:.0f} kg/m^3 (the packing fraction inside the half-mass radius times 2000): "
             f"P = sqrt(3 pi / (G rho)) = {2 * np.pi / omega / 3600:.3f} h.", "",
             "| spin, of the limit | period, h | spin after 6 h, of the limit | lifted off after 6 h, of the mass | of it unbound | axes of what touches, m | drift of angular momentum |",
             "|--:|--:|--:|--:|--:|--:|--:|"]
    for row in rows:
        lines.append(f"| {row['part']} | {2 * np.pi / omega / row['part'] / 3600:.3f} | {row['end'] / omega:.3f} | {row['lifted']:.3f} | {row['lost']:.3f} | "
                     + ", ".join(f"{a:.0f}" for a in row["axes"]) + f" | {row['drift']:.1e} |")
    (HERE / "results.md").write_text("\n".join(lines) + "\n")
    figure, panels = plt.subplots(1, len(rows), figsize=(3.2 * len(rows), 3.5), facecolor=tuple(SKY), squeeze=False)
    for panel, row in zip(panels[0], rows):
        position, radius = row["frame"]
        camera = Camera(np.array([0.3, -1, 0.35]), np.array([0, 0, 1.0]), np.median(position, axis=0), 260, 260, 420)
        show(panel, camera, render(camera, position, radius, rock(len(radius)), SKY))
        panel.set_title(f"{row['part']} of the limit", color="white", loc="center", fontsize=10)
    scale_bar(panels[0][0], camera)
    figure.subplots_adjust(0.005, 0.01, 0.995, 0.9, wspace=0.02)
    figure.savefig(HERE / "piles.png", dpi=110, facecolor=tuple(SKY))


if __name__ == "__main__":
    main()
