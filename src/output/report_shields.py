# A shield from before its first plate to behind its walls, as flash radiographs would show it.
# SPDX-License-Identifier: BSD-3-Clause
import os

import h5py
import numpy as np

import report_film as film

BEHIND = 0.35  # of the way from the projectile's start to the walls, that is shown behind them
PIXEL = 0.7  # of the coarsest bodies' diameter


def unit(vector):
    return vector / np.linalg.norm(vector)


def rear_of(wall, position, motion):
    """Direction of a wall's rear: as the case tells it, or along what flies, through a flat set."""
    if "rear" in wall:
        return unit(np.array(wall["rear"], float))
    thin = np.linalg.eigh(np.cov(position.T))[1][:, 0]
    return thin if thin @ motion > 0 else -thin


def side_of(rear, motion):
    """Upwards in the picture: in the plane of flight, where the projectile comes at an angle."""
    side = motion - (motion @ rear) * rear
    if np.linalg.norm(side) < 1e-6 * np.linalg.norm(motion):
        side = np.eye(3)[(np.argmax(np.abs(rear)) + 1) % 3]
        side = side - (side @ rear) * rear
    return unit(side)


class Shield:
    """All bodies of a scene with [shields] in which `flies` tells those that fly at the start:
    depths along the way through the first wall, from its rear."""

    def __init__(self, run, bodies, flies):
        self.mass, radius = bodies["mass"][:], bodies["radius"][:]
        position, velocity = (bodies[name + "/value"][0] for name in ("position", "velocity"))
        group = bodies["group"][:]
        names = [one["name"] for one in run.case["groups"]]
        walls = [group == names.index(one["wall"]) for one in run.case["shields"]]
        motion = velocity[flies].mean(axis=0)
        self.rear = rear_of(run.case["shields"][0], position[walls[0]], motion)
        self.side = side_of(self.rear, motion)
        depth, across = position @ self.rear, position @ self.side
        self.zero = (depth + radius)[walls[0]].max()
        last = max((depth + radius)[wall].max() for wall in walls) - self.zero
        start = (depth - radius)[flies].min() - self.zero
        diameter = np.ptp(across[flies]) + 2 * radius[flies].max()
        self.extent = (start - diameter, last + BEHIND * (last - start), across.min() - diameter,
                       across.max() + diameter)
        self.black = film.black_of(self.mass[flies].sum(), diameter)
        self.pixel = 2 * PIXEL * radius.max()

    def map_of(self, position):
        return film.column_map(position @ self.rear - self.zero, position @ self.side, self.mass,
                               self.extent, self.pixel)


def radiographs(run):
    """None where nothing flies at the start."""
    with h5py.File(os.path.join(run.folder, "trajectory.h5")) as file:
        bodies = file["particles/all"]
        speed = np.linalg.norm(bodies["velocity/value"][0], axis=1)
        flies = (speed > speed.max() / 2) & np.isfinite(bodies["mass"][:])
        if not flies.any():
            return None
        shield = Shield(run, bodies, flies)
        times = bodies["position/time"][:]
        frames = film.frames_of(times)
        maps = [shield.map_of(bodies["position/value"][k]) for k in frames]
    return film.strip(times[frames], maps, shield.extent, shield.black, "mm behind the wall")
