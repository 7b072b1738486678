# A shield from before its first plate to behind its walls, as flash radiographs would show it.
# SPDX-License-Identifier: BSD-3-Clause
import os

import h5py
import numpy as np

import report_film as film

BEHIND = 0.35  # of the way from the projectile's start to the walls, that is shown behind them
PIXEL = 0.7  # of the coarsest bodies' diameter


def rear_of(wall, position, motion):
    """Direction of a wall's rear: along its normal, towards where the case has it or things fly."""
    towards = np.array(wall.get("rear", motion), float)
    variance, axes = np.linalg.eigh(np.cov(position.T))
    along = towards @ axes
    # Of a flat wall the thinnest axis; of one that is nearly as thick as wide that along the way.
    thin = np.argmax(np.abs(along) / np.sqrt(np.maximum(variance, 1e-12 * variance.max())))
    return axes[:, thin] * np.sign(along[thin])


def side_of(rear, motion):
    """Upwards in the picture: in the plane of flight, where the projectile comes at an angle."""
    side = motion - (motion @ rear) * rear
    if np.linalg.norm(side) < 1e-6 * np.linalg.norm(motion):
        side = np.eye(3)[(np.argmax(np.abs(rear)) + 1) % 3]
        side = side - (side @ rear) * rear
    return side / np.linalg.norm(side)


class Shield:
    """All bodies of a scene with [shields]: depths along the way through the first wall, from its
    rear and in its frame. Bodies that fly at it at the start are where `flies`, if any do."""

    def __init__(self, run, bodies):
        self.mass, radius = bodies["mass"][:], bodies["radius"][:]
        self.times = bodies["position/time"][:]
        position, velocity = (bodies[name + "/value"][0] for name in ("position", "velocity"))
        group = bodies["group"][:]
        names = [one["name"] for one in run.case["groups"]]
        walls = [group == names.index(one["wall"]) for one in run.case["shields"]]
        self.drift = velocity[walls[0]].mean(axis=0)
        velocity = velocity - self.drift
        speed = np.where(np.isfinite(self.mass) & ~np.any(walls, axis=0),
                         np.linalg.norm(velocity, axis=1), 0)
        self.flies = flies = speed > speed.max() / 2
        if not flies.any():
            return
        motion = velocity[flies].mean(axis=0)
        self.rear = rear_of(run.case["shields"][0], position[walls[0]], motion)
        self.side = side_of(self.rear, motion)
        depth, across = position @ self.rear, position @ self.side
        self.zero = (depth + radius)[walls[0]].max()
        last = max((depth + radius)[wall].max() for wall in walls) - self.zero
        start = (depth - radius)[flies].min() - self.zero
        diameter = np.ptp(across[flies]) + 2 * radius[flies].max()
        low, high = start - diameter, last + BEHIND * (last - start)
        # About the middle of the way on which it would fly on to the wall's rear.
        middle = across[flies].mean() - start / 2 * (motion @ self.side) / (motion @ self.rear)
        half = film.HIGHEST / 2 * (high - low)
        shown = across[flies | np.any(walls, axis=0)]
        self.extent = (low, high, max(shown.min() - diameter, middle - half),
                       min(shown.max() + diameter, middle + half))
        self.black = film.black_of(self.mass[flies].sum(), diameter)
        self.pixel = 2 * PIXEL * radius.max()

    def map_of(self, position, time):
        position = position - (time - self.times[0]) * self.drift
        return film.column_map(position @ self.rear - self.zero, position @ self.side, self.mass,
                               self.extent, self.pixel)


def radiographs(run):
    """None where nothing flies at the start, or the run began later, in another folder."""
    with h5py.File(os.path.join(run.folder, "trajectory.h5")) as file:
        bodies = file["particles/all"]
        shield = Shield(run, bodies)
        if not shield.flies.any() or shield.times[0] > 0:
            return None
        frames = film.frames_of(shield.times)
        maps = [shield.map_of(bodies["position/value"][k], shield.times[k]) for k in frames]
    return film.strip(shield.times[frames], maps, shield.extent, shield.black, "mm behind the wall")
