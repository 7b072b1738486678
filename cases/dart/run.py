# DART at several resolutions, densities and hand-overs, each beside the observations; how much is
# ejected how fast.
# SPDX-License-Identifier: BSD-3-Clause
"""run.py [--only-table]: runs what is missing in out/, writes results.md, ejecta.png and bodies.png
beside this script."""
import pathlib
import shutil
import sys
import tomllib

import h5py
import matplotlib
import numpy as np

HERE = pathlib.Path(__file__).parent
sys.path[:0] = [str(HERE.parent), str(HERE.parent / "didymoon")]
from program import spall  # noqa: E402
from remnants import G, axes, largest_remnant, last_frame, results  # noqa: E402
from table import look_up  # noqa: E402

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

RESOLUTIONS = (1.0, 0.5, 0.25)  # m: the largest radius at the site
HAND_OVERS = (2.0, 3.0, 5.0)  # m, on the piles of 1 m; the case's is 3 m
SEEDS = (1, 2, 3)
DENSITY, ERROR, VOLUME = 1540, 220, 2.78e9 / 1540  # kg/m^3 (Makadia et al. 2026), m^3
DENSITIES = (DENSITY - ERROR, DENSITY, DENSITY + ERROR)  # the outer ones at 1 m alone
COHESION = 0.44  # N at 1 m: 2 Pa by Rumpf's formula, as the square of the size
MASS, SPEED, DELTA = 579.4, 6144.9, 1000  # kg, m/s, kg/m^3, of the impactor
SPEEDS = (0.1, 0.3, 1, 3, 10)  # m/s
ROWS = [
    ("bodies", None, ""),
    ("smallest radius", None, "m"),
    ("dv", "deflection.dv", "m/s"),
    ("beta, vector formula", "deflection.beta", ""),
    ("beta along the flight", "deflection.beta_along", ""),
    ("change of the period", "deflection.dT_min", "min"),
    ("launched within the hand-over", "coupling.inner_momentum", "m U"),
    ("given to boulders", "coupling.given_momentum", "m U"),
    ("energy of the boulders' flow", "coupling.flow_energy", "m U^2/2"),
    ("mass launched beyond the hand-over, by the formulas", "coupling.outer_mass", "kg"),
    ("of it boulders were there", "coupling.found_mass", "kg"),
    ("ejecta: boulders", "ejecta.count", ""),
    ("their mass", "ejecta.mass", "kg"),
    ("the fastest boulder", "ejecta.fastest", "m/s"),
    ("half-aperture with half of their momentum (sum of sizes)", "ejecta.cone_half_deg", "deg"),
    ("with 90 % of it", "ejecta.cone_most_deg", "deg"),
    ("boulders of 0.2 to 3.6 m radius beyond 1 m/s", "fast.count", ""),
    ("the sum of their m v sizes", "fast.momentum", "m U"),
    ("boulders up to 7 m across at 0.27 to 0.33 m/s", "slow.count", ""),
    ("their mass ", "slow.mass", "kg"),
    ("mass of the pile", "pile.mass", "kg"),
    ("its axes", "pile.axes", "m"),
    ("axes after", "after.axes", "m"),
    ("a/b after", "after.a_over_b", ""),
    ("mass that moved by more than 1 m and stayed", "after.moved", "kg"),
    ("spin after", "after.spin_deg_h", "deg/h"),
    ("density of a boulder", None, "kg/m^3"),
    ("momentum open after the hand-over (worst)", "coupling.momentum_closure", "m U"),
    ("momentum not closed at a read-out (worst)", "deflection.momentum_closure", "m U"),
    ("drift of momentum (worst)", "conservation.linear", "m U"),
    ("energy unexplained, of the dissipated (worst)", "conservation.energy_unexplained", ""),
]

def observed():
    with open(HERE / "reference.toml", "rb") as file:
        return {row["key"]: (row["printed"], row.get("note", ""))
                for row in tomllib.load(file)["row"]}


def show(value):
    if isinstance(value, list):
        return (", " if len(value) == 3 else " to ").join(show(one) for one in value)
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def scatter(values):
    """Mean ± half of the range over seeds."""
    values = np.array(values, dtype=float)
    spread = (f" ± {np.ptp(values) / 2:.2g}"
              if np.ptp(values) > 1e-9 * np.max(np.abs(values)) else "")
    return f"{values.mean():.4g}{spread}"


def row_of(name, key, runs):
    """A cell of the table: all seeds' runs at one resolution and density, as (folder, results)."""
    if name == "bodies":
        return scatter([len(last_frame(folder)[2]) - 1 for folder, _ in runs])
    if name == "smallest radius":
        return f"{min(last_frame(folder)[2][:-1].min() for folder, _ in runs):.3g}"
    if key is None:
        _, _, radius, mass = last_frame(runs[0][0])
        return f"{mass[0] / (4 / 3 * np.pi * radius[0]**3):.4g}"
    values = [look_up(run, key) for _, run in runs]
    if name.endswith("(worst)"):
        return f"{max(map(abs, values)):.1e}"
    return ", ".join(map(scatter, zip(*values))) if isinstance(values[0], list) else scatter(values)


def crater_radius(density):
    """m, of sand under gravity (Housen & Holsapple 2011, eq. 12): H1 = 0.59, mu = 0.41,
    nu = 0.4."""
    h1, mu, nu = 0.59, 0.41, 0.4
    a, gravity = ((3 * MASS / (4 * np.pi * DELTA)) ** (1 / 3),
                  G * density * VOLUME / (3 * VOLUME / (4 * np.pi)) ** (2 / 3))
    return (h1 * (MASS / density) ** (1 / 3) * (gravity * a / SPEED**2) ** (-mu / (2 + mu))
            * (density / DELTA) ** ((2 + mu - 6 * nu) / (3 * (2 + mu))))


class Bodies:
    """The target's bodies before the impact and at the end, and which of them are what is left of
    it."""

    def __init__(self, folder):
        with h5py.File(folder / "trajectory.h5") as file:
            rows = file["particles/all"]
            # The first frame with the impactor.
            struck = np.flatnonzero(rows["id/value"][:, -1] >= 0)[0]
            n = len(rows["radius"]) - 1
            self.before, self.spin = (rows["position/value"][max(struck - 1, 0)][:n],
                                      rows["angular_velocity/value"][-1][:n])
        self.position, self.velocity, self.radius, self.mass = (x[:n] for x in last_frame(folder))
        self.inside = largest_remnant(self.position, self.velocity, self.radius, self.mass)
        self.drift = np.average(self.velocity[self.inside], axis=0, weights=self.mass[self.inside])
        self.speed = np.linalg.norm(self.velocity - self.drift, axis=1)

    def plume(self):
        """Speeds (m/s) of the ejecta relative to what is left, fastest first, and the mass that is
        at least as fast (kg)."""
        order = np.argsort(-self.speed[~self.inside])
        return self.speed[~self.inside][order], np.cumsum(self.mass[~self.inside][order])

    def measures(self):
        out, r, m, v = ~self.inside, self.radius, self.mass, self.speed
        fast = out & (r >= 0.2) & (r <= 3.6) & (v > 1)
        slow = out & (2 * r <= 7) & (v >= 0.27) & (v <= 0.33)
        x, u, mass = (self.position[self.inside], self.velocity[self.inside] - self.drift,
                      m[self.inside])
        x = x - np.average(x, axis=0, weights=mass)
        own = 0.4 * mass * r[self.inside] ** 2
        turning = (mass[:, None] * np.cross(x, u)
                   + own[:, None] * self.spin[self.inside]).sum(axis=0)
        inertia = np.eye(3) * (mass @ (x**2).sum(axis=1) + own.sum()) - (mass[:, None] * x).T @ x
        spin = np.linalg.solve(inertia, turning)
        was = self.before[self.inside]
        moved = np.linalg.norm(x - was + np.average(was, axis=0, weights=mass), axis=1)
        after = axes(self.position[self.inside], mass)
        return {"fast": {"count": int(fast.sum()),
                         "momentum": float((m * v)[fast].sum() / (MASS * SPEED))},
                "slow": {"count": int(slow.sum()), "mass": float(m[slow].sum())},
                "after": {"axes": [float(one) for one in after],
                          "a_over_b": float(after[0] / after[1]),
                          "moved": float(mass[moved > 1].sum()),
                          "spin_deg_h": float(np.degrees(np.linalg.norm(spin)) * 3600)}}


def run(folder, changes, start="cases/dart/case.toml"):
    command = "run" if start.endswith(".toml") else "resume"
    spall(command, start, "--out", folder, "--overwrite", changes=changes, ranks=2, shows=True)


def main():
    folders = {}
    for seed in SEEDS:
        for r, density in [*((r, DENSITY) for r in RESOLUTIONS),
                           *((1.0, density) for density in DENSITIES if density != DENSITY)]:
            folders[r, density, 3.0, seed] = pathlib.Path(f"out/dart-{density}-{r:g}-{seed}")
        for x in HAND_OVERS:
            folders.setdefault((1.0, DENSITY, x, seed),
                               pathlib.Path(f"out/dart-hand_over-{x:g}-{seed}"))
    for (r, density, x, seed), folder in folders.items():
        if "--only-table" in sys.argv or (folder / "results.toml").exists():
            continue
        if x != 3.0:
            run(folder, [f"phases.impact.impactor.coupling.hand_over={x} m"],
                f"out/dart-{DENSITY}-1-{seed}/after_settling.h5")
            continue
        run(folder, [f"seed={seed}", f"groups.dimorphos.total_mass={density * VOLUME} kg",
                     f"groups.dimorphos.packing.smallest={r} m",
                     f"phases.impact.cohesion={COHESION * r**2} N",
                     f"phases.impact.impactor.coupling.density={density} kg/m^3",
                     "phases.impact.impactor.coupling.crater_radius="
                     f"{crater_radius(density):.4g} m"])
    there, bodies = {}, {}
    for key, folder in folders.items():
        if (folder / "results.toml").exists():
            bodies[key] = Bodies(folder)
            there[key] = (folder, results(folder) | bodies[key].measures())

    def runs_at(*at):
        return [one for key, one in there.items() if key[:3] == at]

    def table(columns, names, notes=False, rows=None):
        lines = ["| | | " + ("observed | " if notes else "") + " | ".join(names)
                 + (" | note |" if notes else " |"),
                 "|---|---|" + "--:|" * (len(columns) + notes) + ("---|" if notes else "")]
        for name, key, unit in ROWS:
            if rows and name not in rows:
                continue
            printed, note = observed().get(key, ("", ""))
            cells = [row_of(name, key, runs_at(*at)) for at in columns]
            lines.append("| " + " | ".join([
                name.strip(), unit, *([show(printed)] if notes else []), *cells,
                *([note] if notes else [])]) + " |")
        return "\n".join(lines)
    main_columns = [at for at in ((r, DENSITY, 3.0) for r in RESOLUTIONS) if runs_at(*at)]
    densities = [at for at in ((1.0, density, 3.0) for density in DENSITIES) if runs_at(*at)]
    hand_overs = [at for at in ((1.0, DENSITY, x) for x in HAND_OVERS) if runs_at(*at)]
    few = ("dv", "beta, vector formula", "beta along the flight", "change of the period",
           "launched within the hand-over", "given to boulders", "their mass",
           "the fastest boulder", "a/b after", "density of a boulder")

    def seeds(at):
        return f"{len(runs_at(*at))} seed{'s' if len(runs_at(*at)) > 1 else ''}"

    def faster(key, v):
        speed, mass = bodies[key].plume()
        return mass[np.sum(speed >= v) - 1] if np.any(speed >= v) else 0.0
    masses = ["| " + " | ".join([
        f"{v:g} m/s", *(scatter([faster(key, v) for key in there if key[:3] == at])
                        for at in main_columns)]) + " |" for v in SPEEDS]
    first = next(iter(there.values()))[1]
    at_times = [f"{t:.3g} s" for t in first["read_out"]["since_impact"]]
    reads = [f"| {r:g} m | {density} | {x:g} m | {seed} | "
             + " | ".join(f"{1e3 * dv:.4g}" for dv in one["read_out"]["dv"]) + " | "
             + " | ".join(f"{b:.4g}" for b in one["read_out"]["beta"]) + " |"
             for (r, density, x, seed), (_, one) in there.items()]
    commits = sorted({one["provenance"]["commit"] for _, one in there.values()})
    names = [f"{r:g} m at the site ({seeds((r, density, x))})" for r, density, x in main_columns]
    (HERE / "results.md").write_text(
        "# DART: the runs beside the observations\nWritten by `cases/dart/run.py`; runs by commit "
        f"{', '.join(commits)}; at the last read-out unless said otherwise; mean over the seeds ± "
        f"half of their range. Dimorphos has {DENSITY} kg/m^3, the hand-over is 3 m.\n\n"
        + table(main_columns, names, notes=True)
        + "\n\n## By density, 1 m at the site\n\n"
        + table(densities, [f"{at[1]} kg/m^3 ({seeds(at)})" for at in densities], rows=few)
        + "\n\n## By hand-over, 1 m at the site\n\n"
        + table(hand_overs, [f"{at[2]:g} m ({seeds(at)})" for at in hand_overs], rows=few)
        + "\n\n## Mass ejected faster than v, kg\n\n| | " + " | ".join(names)
        + " |\n|---|" + "--:|" * len(names) + "\n" + "\n".join(masses)
        + "\n\n## In time\n\n| | kg/m^3 | hand-over | seed | "
        + " | ".join(f"dv at {t}, mm/s" for t in at_times) + " | "
        + " | ".join(f"beta at {t}" for t in at_times)
        + " |\n|---|--:|--:|--:|" + "--:|" * (2 * len(at_times)) + "\n" + "\n".join(reads) + "\n")

    figure, panel = plt.subplots(figsize=(8, 4.4), layout="constrained")
    colors = dict(zip(RESOLUTIONS, ("#3f8f5b", "#2f6db3", "#8a4fb0")))
    for key in there:
        if key[:3] in main_columns:
            panel.plot(*bodies[key].plume(), drawstyle="steps-post", color=colors[key[0]],
                       label=f"{key[0]:g} m at the site" if key[3] == SEEDS[0] else None)
    panel.axhspan(*observed()["ejecta.mass"][0], color="#d9822b", alpha=0.25, lw=0,
                  label="all ejecta, observed (Ferrari et al. 2025)")
    panel.set(xscale="log", yscale="log", xlabel="speed v relative to what is left (m/s)",
              ylabel="mass ejected faster than v (kg)")
    panel.grid(color="#e4e8ee")
    panel.legend(frameon=False)
    figure.savefig(HERE / "ejecta.png", dpi=110)
    finest = [folder for key, (folder, _) in there.items() if key[:3] == main_columns[-1]][0]
    spall("report", finest)
    shutil.copy(finest / "report/bodies.png", HERE / "bodies.png")


if __name__ == "__main__":
    main()
