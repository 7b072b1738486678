# Grains of a run, and slices through them as pictures.
# SPDX-License-Identifier: BSD-3-Clause
import pathlib

import h5py
import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402


def read(folder):
    """Positions (m) of all grains in all snapshots, their times (s), the radius of the first grain
    (m)."""
    with h5py.File(pathlib.Path(folder) / "trajectory.h5") as file:
        return (
            file["particles/all/position/value"][:],
            file["particles/all/position/time"][:],
            float(np.ravel(file["particles/all/radius"])[0]),
        )


def draw(file, all_x, times, grain, frames, height, top=None):
    """The slice twelve grain radii thick along y = 0 at these `frames`, one below the other;
    `height` of the picture in inches, `top` of the axes in mm."""
    figure, axes = plt.subplots(len(frames), 1, figsize=(8, height), sharex=True, sharey=True)
    for axis, k in zip(axes, frames):
        x = 1e3 * all_x[k]
        slab = x[np.abs(x[:, 1]) < 6e3 * grain]
        slab = slab[np.argsort(-slab[:, 1])]
        axis.scatter(slab[:, 0], slab[:, 2], s=9, c=slab[:, 1], cmap="copper", linewidths=0)
        axis.set_aspect("equal")
        axis.set_title(f"{1e3 * times[k]:.0f} ms", loc="right", fontsize=9, y=0.7)
        if top:
            axis.set_ylim(0, top)
    axes[-1].set_xlabel("mm")
    figure.tight_layout()
    figure.savefig(file, dpi=90)
