"""A tank of gas under pressure: its breathing, and what becomes of it when a particle goes through.

    PYTHONPATH=build/release/python /usr/bin/python3 cases/tank/tank.py [--breathe]

The gas is a force of this program's own on the bodies of the shell; see README.md. mpirun -n 2
before it shares the work. The shot writes tank.png beside this file.
SPDX-License-Identifier: BSD-3-Clause
"""
import argparse
import math
from pathlib import Path

import numpy as np
import spall
from mpi4py import MPI

HERE = Path(__file__).parent
OUTER, INNER = 20e-3, 17.6e-3  # m, as in case.toml
YOUNG, POISSON, DENSITY = 68.9e9, 0.33, 2703.0  # of its material
GAMMA, SOUND = 1.4, 350.0  # of nitrogen at 295 K; m/s
FILLING = 30e-6  # s, two periods of the breathing: slow enough to leave the shell still
MIDDLE = (OUTER + INNER) / 2


def total(value):
    return MPI.COMM_WORLD.allreduce(value)


class Gas:
    """Presses on the shell alike everywhere, and flows out of what is open as from a nozzle."""

    def __init__(self, pressure, filling):
        self.full, self.filling = pressure, filling
        self.pressure = 0.0 if filling else pressure
        self.hole = 0.0  # m^2
        self.time = 0.0
        self.mass = None
        # Pixels of about two spacings: rings of equal height about x, so that all have the same
        # area, and are nearly square where the particle hits.
        self.rings, self.sectors = 24, 48

    def whole(self, bodies):
        """Bodies of the shell that have neither failed nor left."""
        far = np.linalg.norm(bodies.position, axis=1)
        return (bodies.group == 0) & (bodies.damage < 1) & (np.abs(far - MIDDLE) < OUTER - INNER)

    def push(self, bodies, forces):
        if self.mass is None:
            self.mass = total(bodies.mass[bodies.group == 0].sum())
        bears = self.whole(bodies)
        place = bodies.position[bears]
        out = place / np.linalg.norm(place, axis=1)[:, None]
        share = bodies.mass[bears] / self.mass
        forces[bears] += self.pressure * 4 * math.pi * INNER**2 * share[:, None] * out

    def pixels_of(self, place):
        far = np.linalg.norm(place, axis=1)
        ring = np.minimum((0.5 * (1 + place[:, 0] / far) * self.rings).astype(int), self.rings - 1)
        turn = np.arctan2(place[:, 1], place[:, 2]) / (2 * math.pi) + 0.5
        sector = np.minimum((turn * self.sectors).astype(int), self.sectors - 1)
        return ring * self.sectors + sector

    def go_on(self, sim):
        """To the time of the simulation: fills the tank, finds what is open, lets gas flow out."""
        bodies, step = sim.bodies, sim.time - self.time
        self.time = sim.time
        seen = np.zeros(self.rings * self.sectors)
        np.add.at(seen, self.pixels_of(bodies.position[self.whole(bodies)]), 1)
        closed = np.count_nonzero(total(seen))
        self.hole = (1 - closed / len(seen)) * 4 * math.pi * INNER**2
        if sim.time < self.filling:
            self.pressure = self.full * sim.time / self.filling
            return
        # Choked and isentropic (any textbook of gas dynamics): V dp/dt = -gamma p w A.
        choked = (2 / (GAMMA + 1))**((GAMMA + 1) / (2 * (GAMMA - 1)))
        speed = SOUND * (self.pressure / self.full)**((GAMMA - 1) / (2 * GAMMA))
        volume = 4 / 3 * math.pi * INNER**3
        self.pressure *= math.exp(-GAMMA * choked * speed * self.hole / volume * step)


def swelling(sim, gas):
    """Of the shell that bears: m, mean distance from the middle; Pa, mean stress along it; kg."""
    bodies = sim.bodies
    shell = gas.whole(bodies)
    place = bodies.position[shell]
    far = np.linalg.norm(place, axis=1)
    out = place / far[:, None]
    direct, shear = bodies.direct_stress[shell], bodies.shear_stress[shell]
    radial = (np.einsum("ij,ij->i", direct, out**2)
              + 2 * (shear[:, 0] * out[:, 1] * out[:, 2] + shear[:, 1] * out[:, 2] * out[:, 0]
                     + shear[:, 2] * out[:, 0] * out[:, 1]))
    along = (direct.sum(axis=1) - radial) / 2 - bodies.pressure[shell]
    count = total(np.count_nonzero(shell))
    return (total(far.sum()) / count, total(along.sum()) / count, total(bodies.mass[shell].sum()))


def formulas(pressure):
    """Of a thin shell: m, s, Pa. The stress is what balances the gas on half a tank, exactly."""
    stress = pressure * INNER**2 / (OUTER**2 - INNER**2)
    return (stress * MIDDLE * (1 - POISSON) / YOUNG,
            2 * math.pi * MIDDLE * math.sqrt(DENSITY * (1 - POISSON) / (2 * YOUNG)), stress)


def follow(pressure, filling, until, layers):
    sim = spall.Simulation(str(HERE / "case.toml"), set={
        "groups.shell.packing.diameter": (OUTER - INNER) / layers})
    gas = Gas(pressure, filling)
    sim.add_force(gas.push)
    rows = [(0.0, *swelling(sim, gas), gas.pressure, 0.0)]

    def between(sim):
        gas.go_on(sim)
        rows.append((sim.time, *swelling(sim, gas), gas.pressure, gas.hole))

    sim.run_until(until, each=between)
    return sim, gas, np.array(rows).T


def breathe(pressure, layers):
    """The pressure is there at once: the shell swings about its new size."""
    known_size, known_period, known_stress = formulas(pressure)
    _, _, (time, size, stress, *_) = follow(pressure, 0, 4.2 * known_period, layers)
    size -= size[0]
    middle = size.mean()
    rises = [k for k in range(1, len(size)) if size[k - 1] < middle <= size[k]]
    crossings = [np.interp(middle, size[k - 1:k + 1], time[k - 1:k + 1]) for k in rises]
    period = np.mean(np.diff(crossings))
    whole = (time >= crossings[0]) & (time < crossings[-1])
    if spall.rank() == 0:
        print("| | found | thin shell | |\n|---|--:|--:|--:|")
        for name, found, known, unit in (
                ("mean swelling, um", size[whole].mean(), known_size, 1e6),
                ("period, us", period, known_period, 1e6),
                ("mean stress along the shell, MPa", stress[whole].mean(), known_stress, 1e-6)):
            print(f"| {name} | {unit * found:.2f} | {unit * known:.2f} | "
                  f"{100 * (found / known - 1):+.1f} % |")


def shoot(pressure, layers):
    sim, gas, (time, size, stress, mass, left, hole) = follow(pressure, FILLING, 120e-6, layers)
    still = (time > 45e-6) & (time < 60e-6)
    known_size, _, known_stress = formulas(pressure)
    cut = cut_through(sim)
    if spall.rank() != 0:
        return
    print(f"filled: {1e6 * (size[still].mean() - size[0]):.1f} um wider (thin shell "
          f"{1e6 * known_size:.1f}), {1e-6 * stress[still].mean():.1f} MPa along it "
          f"({1e-6 * known_stress:.1f})")
    area = hole[-1]
    choked = (2 / (GAMMA + 1))**((GAMMA + 1) / (2 * (GAMMA - 1)))
    volume = 4 / 3 * math.pi * INNER**3
    print(f"open in the end: {1e6 * area:.1f} mm^2, as a circle of "
          f"{2e3 * math.sqrt(area / math.pi):.1f} mm; {1e3 * (mass[0] - mass[-1]):.3f} g have "
          f"failed; the gas has lost {100 * (1 - left[-1] / pressure):.2f} % of its pressure")
    if area > 0:  # p = p0 (1 + (gamma - 1)/2 t/tau)^(-2 gamma/(gamma - 1)), tau = V/(choked c A)
        halves = 2 / (GAMMA - 1) * (2**((GAMMA - 1) / (2 * GAMMA)) - 1)
        print(f"half of it is gone after "
              f"{1e3 * halves * volume / (choked * SOUND * area):.2f} ms")
    draw(cut, sim.time, time, size, left, hole)


def cut_through(sim):
    """(x, z), and whether they have failed, of the shell's bodies near a plane through its middle;
    of all ranks, on the first."""
    bodies = sim.bodies
    near = (bodies.group == 0) & (np.abs(bodies.position[:, 1]) < (OUTER - INNER) / 3)
    mine = np.column_stack([bodies.position[near][:, [0, 2]], bodies.damage[near] >= 1])
    return np.concatenate(MPI.COMM_WORLD.gather(mine) or [mine])


def draw(cut, now, time, size, left, hole):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    figure, axes = plt.subplots(1, 2, figsize=(10, 3.8), layout="constrained")
    for failed, color, name in ((0, "#2f6db3", "whole"), (1, "#c8452f", "failed")):
        x, z, _ = cut[cut[:, 2] == failed].T
        axes[0].scatter(1e3 * x, 1e3 * z, s=3, color=color, label=name)
    axes[0].set(aspect="equal", xlim=(-30, 30), ylim=(-30, 30), xlabel="mm", ylabel="mm",
                title=f"cut through the tank after {1e6 * now:.0f} µs")
    axes[0].legend(fontsize=8)
    axes[1].plot(1e6 * time, 1e6 * (size - size[0]), label="swelling (µm)")
    axes[1].plot(1e6 * time, 1e6 * hole, label="open (mm²)")
    axes[1].plot(1e6 * time, 1e-6 * left, label="pressure (MPa)")
    axes[1].set(xlabel="time (µs)", xlim=(0, None), ylim=(0, 60))
    axes[1].legend(fontsize=8)
    figure.savefig(HERE / "tank.png", dpi=110)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--pressure", type=float, default=20e6, help="Pa")
    parser.add_argument("--layers", type=int, default=3, help="of bodies in the shell")
    parser.add_argument("--breathe", action="store_true", help="only fill the tank, at once")
    options = parser.parse_args()
    (breathe if options.breathe else shoot)(options.pressure, options.layers)


if __name__ == "__main__":
    main()
