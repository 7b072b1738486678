"""The same cylinder by another method: axisymmetric finite elements with the same law of the metal.

    /usr/bin/python3 cases/taylor/finite_elements.py [--material copper] [--speed 190]
    [--across 12 20] [--sticks]          prints a table

So an error of the law and its constants can be told from one of Spall's bodies. Quadrilaterals with
one point, viscosity against hourglasses (Flanagan & Belytschko, Int. J. Numer. Meth. Engng 17
(1981) 679), Jaumann's rate, return to Johnson and Cook's flow stress, von Neumann's viscosity where
elements shrink, leapfrog. The wall is rigid and has no friction. Nothing fails. The cold energy
has no part in the pressure, and what viscosity takes does not heat: a micrometre of the length.
SPDX-License-Identifier: BSD-3-Clause
"""
import argparse
import tomllib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

MATERIALS = Path(__file__).parent.parent / "materials"
LENGTH, RADIUS, UNTIL = 25.4e-3, 3.81e-3, 75e-6  # m, m, s
UNITS = {"Pa": 1, "MPa": 1e6, "GPa": 1e9, "kg/m^3": 1, "m/s": 1, "J/(kg K)": 1, "K": 1}
ROOM = 298.0  # K
SQUARE, LINEAR = 1.5, 0.06  # of the viscosity, textbook values
HOURGLASS = 0.05
STEP = 0.4  # of what sound allows
SIGNS = np.array([1, -1, 1, -1.0])  # of an hourglass


class Metal:
    """Constants in SI, as the library's file calls them."""

    def __init__(self, name):
        for key, value in tomllib.loads((MATERIALS / f"{name}.toml").read_text()).items():
            if isinstance(value, str) and value.split(" ", 1)[-1] in UNITS:
                number, unit = value.split(" ", 1)
                value = float(number) * UNITS[unit]
            setattr(self, key, value)
        self.shear = self.youngs_modulus / 2 / (1 + self.poisson_ratio)
        self.bulk = self.density * self.sound_speed**2
        self.waves = np.sqrt((self.bulk + 4 / 3 * self.shear) / self.density)

    def flow_stress(self, strain, rate, heat):
        hot = np.clip(heat / self.specific_heat / (self.melting_point - ROOM), 0, 1)
        hard = self.johnson_cook_a + self.johnson_cook_b * np.maximum(
            strain, 1e-12)**self.johnson_cook_n
        return hard * (1 + self.johnson_cook_c * np.log(np.maximum(rate, 1))) * (
            1 - hot**self.johnson_cook_m)

    def pressure(self, volume, heat):
        """volume: of that at rest."""
        eta = 1 - volume
        shock = self.bulk * eta / (1 - self.hugoniot_slope * eta)**2
        cold = shock * (1 - self.gruneisen * eta / 2)
        return np.where(eta > 0, cold, self.bulk * (1 / volume - 1)) + (
            self.gruneisen * self.density * heat)


class Mesh:
    """`across` elements on the diameter."""

    def __init__(self, across):
        columns, rows = across // 2, round(across * LENGTH / RADIUS / 2)
        r, z = np.linspace(0, RADIUS, columns + 1), np.linspace(0, LENGTH, rows + 1)
        self.at_rest = np.array([(a, b) for b in z for a in r])
        first = np.array([j * (columns + 1) + i for j in range(rows) for i in range(columns)])
        self.nodes = np.stack([first, first + 1, first + columns + 2, first + columns + 1], 1)

    def measures(self, x):
        """Corners, areas, gradients of the shape functions along r and z, radius of middles."""
        corner = x[self.nodes]
        r, z = corner[:, :, 0], corner[:, :, 1]
        area = ((r[:, 2] - r[:, 0]) * (z[:, 3] - z[:, 1]) +
                (r[:, 1] - r[:, 3]) * (z[:, 2] - z[:, 0])) / 2
        along_r = np.stack([z[:, 1] - z[:, 3], z[:, 2] - z[:, 0]], 1) / (2 * area[:, None])
        along_z = np.stack([r[:, 3] - r[:, 1], r[:, 0] - r[:, 2]], 1) / (2 * area[:, None])
        return (corner, area, np.hstack([along_r, -along_r]), np.hstack([along_z, -along_z]),
                r.mean(axis=1))

    def summed(self, of_corners):
        total = np.zeros((len(self.at_rest), *of_corners.shape[2:]))
        np.add.at(total, self.nodes, of_corners)
        return total


def shortest_side(corner):
    middles = (corner + np.roll(corner, -1, axis=1)) / 2
    return min(np.linalg.norm(middles[:, k] - middles[:, k + 2], axis=1).min() for k in (0, 1))


@dataclass
class State:
    deviator: np.ndarray  # Pa; rr, zz, around the axis, rz
    strain: np.ndarray  # plastic
    heat: np.ndarray  # J/kg, of plastic work


def returned(metal, state, trial, h):
    """Scales the trial deviator back to the flow stress: the share that is left."""
    mises = np.sqrt(1.5 * (np.sum(trial[:, :3]**2, axis=1) + 2 * trial[:, 3]**2))
    low, high = np.zeros_like(mises), mises / (3 * metal.shear)
    for _ in range(40):
        middle = (low + high) / 2
        beyond = mises - 3 * metal.shear * middle > metal.flow_stress(
            state.strain + middle, middle / h, state.heat)
        low, high = np.where(beyond, middle, low), np.where(beyond, high, middle)
    flows = mises > metal.flow_stress(state.strain, 1, state.heat)
    more = np.where(flows, (low + high) / 2, 0)
    left = np.where(flows, 1 - 3 * metal.shear * more / np.maximum(mises, 1), 1)
    state.strain += more
    return left, mises * left * more


def run(metal, speed, across, sticks=False):
    """mm: length and foot; the plastic work, of the energy at first. `sticks`: the wall holds what
    rests on it."""
    mesh = Mesh(across)
    x, v = mesh.at_rest.copy(), np.tile([0, -float(speed)], (len(mesh.at_rest), 1))
    axis, base = x[:, 0] == 0, x[:, 1] == 0
    _, area, _, _, middle = mesh.measures(x)
    at_rest = 2 * np.pi * middle * area
    mass = metal.density * at_rest
    node_mass = mesh.summed(np.tile(mass[:, None] / 4, (1, 4)))
    state = State(np.zeros((len(mass), 4)), np.zeros_like(mass), np.zeros_like(mass))
    time = 0
    while time < UNTIL:
        corner, area, along_r, along_z, middle = mesh.measures(x)
        h = STEP * shortest_side(corner) / metal.waves
        u = v[mesh.nodes]
        r_by_z, z_by_r = np.sum(along_z * u[:, :, 0], 1), np.sum(along_r * u[:, :, 1], 1)
        rate = np.stack([np.sum(along_r * u[:, :, 0], 1), np.sum(along_z * u[:, :, 1], 1),
                         u[:, :, 0].mean(axis=1) / middle, (r_by_z + z_by_r) / 2], 1)
        spin, growth = (r_by_z - z_by_r) / 2, rate[:, :3].sum(axis=1)
        volume = 2 * np.pi * middle * area
        old = state.deviator
        trial = old + 2 * metal.shear * h * rate
        trial[:, :3] -= 2 / 3 * metal.shear * h * growth[:, None]
        trial[:, 0] += 2 * h * spin * old[:, 3]
        trial[:, 1] -= 2 * h * spin * old[:, 3]
        trial[:, 3] += h * spin * (old[:, 1] - old[:, 0])
        left, work = returned(metal, state, trial, h)
        state.deviator = trial * left[:, None]
        state.heat += work * volume / mass
        size = np.sqrt(area)
        closing = np.maximum(0, -growth * size)
        viscous = mass / volume * closing * (SQUARE * closing + LINEAR * metal.waves)
        stress = state.deviator.copy()
        stress[:, :3] -= (metal.pressure(volume / at_rest, state.heat) + viscous)[:, None]
        force = -volume[:, None, None] * np.stack(
            [stress[:, :1] * along_r + stress[:, 3:] * along_z +
             stress[:, 2:3] / (4 * middle[:, None]),
             stress[:, 1:2] * along_z + stress[:, 3:] * along_r], 2)
        shape = SIGNS - along_r * (corner[:, :, 0] @ SIGNS)[:, None] - along_z * (
            corner[:, :, 1] @ SIGNS)[:, None]
        resists = HOURGLASS * mass / volume * metal.waves * 2 * np.pi * middle * size / 4
        force -= shape[:, :, None] * (resists[:, None] * np.einsum("ei,eik->ek", shape, u))[:, None]
        v += h * mesh.summed(force) / node_mass[:, None]
        v[axis, 0] = 0
        rests = base & (x[:, 1] <= 0) & (v[:, 1] < 0)
        v[rests, 1] = 0
        if sticks:
            v[rests, 0] = 0
        x += h * v
        time += h
    top = mesh.at_rest[:, 1] == LENGTH
    return (1e3 * (x[top, 1].mean() - x[base, 1].min()), 2e3 * x[base, 0].max(),
            np.sum(mass * state.heat) / (mass.sum() * speed**2 / 2))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--material", default="copper")
    parser.add_argument("--speed", type=float, default=190, help="m/s")
    parser.add_argument("--across", type=int, nargs="+", default=[12, 20])
    parser.add_argument("--sticks", action="store_true", help="the wall holds what rests on it")
    options = parser.parse_args()
    print("| elements across | length, mm | foot, mm | plastic work, of the energy |\n"
          "|--:|--:|--:|--:|")
    for across in options.across:
        length, foot, work = run(Metal(options.material), options.speed, across,
                                 options.sticks)
        print(f"| {across} | {length:.2f} | {foot:.2f} | {100 * work:.1f} % |", flush=True)


if __name__ == "__main__":
    main()
