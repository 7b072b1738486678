"""The shock below a ball that hits a block, by another method: Euler's equations on a grid.

    /usr/bin/python3 cases/breakup/euler.py [--across 36 72]          prints a table

Ball and block are one fluid of Tait's pressure, B ((rho/rho_0)^n - 1) with n = 4 s - 1, which has
the shocks of U = c + s u within 2 % here; it bears no tension, and has no strength and no heat.
Symmetric about the axis; minmod slopes, fluxes of Harten, Lax and van Leer, Heun's steps.
SPDX-License-Identifier: BSD-3-Clause
"""
import argparse

import numpy as np

DENSITY, SOUND, SLOPE = 2703.0, 5350.0, 1.34  # kg/m^3, m/s, of 6061-T6
POWER = 4 * SLOPE - 1
STIFF = DENSITY * SOUND**2 / POWER  # Pa
EMPTY = 1e-4  # of the density
COURANT = 0.3
WIDE, DEEP, HIGH = 2.0, 2.2, 1.3  # ball diameters: radius, block, what is above it
CORNERS = 4  # by which the part of a cell that the ball fills is found, in each direction
FASTEST = 2.5  # times the ball's speed: nearly empty cells are no faster


def pressure(density):
    dense = np.maximum(density / DENSITY, 1)
    return STIFF * (dense**POWER - 1)


def sound(density):
    x = density / DENSITY
    return np.where(x > 1, SOUND * np.maximum(x, 1)**((POWER - 1) / 2), 0)


def face_fluxes(state, along):
    """Of density, axial and radial momentum, through the faces across direction `along`, of states
    with two cells more at each end there."""
    state = np.moveaxis(state, 1 + along, -1)
    known = np.stack([state[0], state[1] / state[0], state[2] / state[0]])
    step = np.diff(known)
    slope = np.where(step[..., 1:] * step[..., :-1] > 0,
                     np.where(abs(step[..., 1:]) < abs(step[..., :-1]), step[..., 1:],
                              step[..., :-1]), 0)
    cells = known[..., 1:-1]
    sides, flows, slowest, fastest = [], [], [], []
    for density, *velocity in (cells[..., :-1] + slope[..., :-1] / 2,
                               cells[..., 1:] - slope[..., 1:] / 2):
        side = np.stack([density, density * velocity[0], density * velocity[1]])
        flow = side * velocity[along]
        flow[1 + along] += pressure(density)
        sides.append(side)
        flows.append(flow)
        slowest.append(velocity[along] - sound(density))
        fastest.append(velocity[along] + sound(density))
    low, high = np.minimum(np.minimum(*slowest), 0), np.maximum(np.maximum(*fastest), 0)
    span = np.where(high - low > 0, high - low, 1)
    flow = (high * flows[0] - low * flows[1] + low * high * (sides[1] - sides[0])) / span
    return np.moveaxis(flow, -1, 1 + along)


def rates(state, h):
    """d/dt of density, axial and radial momentum."""
    radius = (np.arange(state.shape[2]) + 0.5) * h
    axial = np.pad(state, ((0, 0), (2, 2), (0, 0)), mode="edge")
    radial = np.pad(state, ((0, 0), (0, 0), (2, 2)), mode="edge")
    radial[:, :, :2] = state[:, :, 1::-1]  # the axis is a mirror
    radial[2, :, :2] *= -1
    faces = np.arange(state.shape[2] + 1) * h
    rate = -np.diff(face_fluxes(axial, 0), axis=1) / h
    rate -= np.diff(faces * face_fluxes(radial, 1), axis=2) / (radius * h)
    rate[2] += pressure(state[0]) / radius
    return rate


def filled(state, most):
    """Without cells that have lost more than they had, and none faster than `most` (m/s)."""
    state[:, state[0] < EMPTY * DENSITY] = np.array([[EMPTY * DENSITY], [0], [0]])
    speed = np.hypot(state[1], state[2]) / state[0]
    state[1:] *= np.minimum(1, most / np.maximum(speed, most))
    return state


def peaks(diameter, speed, across, depths):
    """The peak pressures on the axis (Pa) at these depths (ball diameters), until sound has come
    through the block."""
    h = diameter / across
    deep, high, wide = round(DEEP * across), round(HIGH * across), round(WIDE * across)
    inner = (np.arange(CORNERS) + 0.5) / CORNERS
    z = ((np.arange(high)[:, None] + inner) * h).reshape(high, 1, CORNERS, 1)
    r = ((np.arange(wide)[:, None] + inner) * h).reshape(1, wide, 1, CORNERS)
    ball = ((z - diameter / 2)**2 + r**2 < diameter**2 / 4).mean(axis=(2, 3))
    state = np.zeros((3, deep + high, wide))
    state[0, :deep] = DENSITY
    state[0, deep:] = DENSITY * np.maximum(ball, EMPTY)
    state[1, deep:] = -speed * DENSITY * ball
    most, now, highest = FASTEST * speed, 0.0, np.zeros(deep)
    while now < DEEP * diameter / SOUND:
        there = state[0] > 0.01 * DENSITY
        swift = np.maximum(abs(state[1]), abs(state[2])) / state[0] + sound(state[0])
        step = COURANT * h / swift[there].max()
        middle = filled(state + step * rates(state, h), most)
        state = filled((state + middle + step * rates(middle, h)) / 2, most)
        now += step
        highest = np.maximum(highest, pressure(state[0, :deep, 0]))
    return np.interp(depths, (np.arange(deep) + 0.5) / across, highest[::-1])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--across", type=int, nargs="+", default=[36, 72], help="cells on the ball")
    parser.add_argument("--diameter", type=float, default=0.9e-3, help="m")
    parser.add_argument("--speed", type=float, default=4e3, help="m/s")
    options = parser.parse_args()
    depths = (0.5, 0.75, 1, 1.25, 1.5)
    print("| across | depth, diameters | peak, GPa |\n|--:|--:|--:|")
    for across in options.across:
        for depth, peak in zip(depths, peaks(options.diameter, options.speed, across, depths)):
            print(f"| {across} | {depth:g} | {peak / 1e9:.2f} |", flush=True)


if __name__ == "__main__":
    main()
