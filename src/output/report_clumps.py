# The spheres of bodies with shapes, as pictures and pages draw them.
# SPDX-License-Identifier: BSD-3-Clause
import h5py
import numpy as np


class Shapes:
    """The spheres of all shapes of a snapshot: one for each body where all bodies are spheres."""

    def __init__(self, file):
        self.centers, self.radii = [np.zeros((1, 3))], [np.ones(1)]
        bodies = file["particles/all"]
        if "shape" in bodies:
            number = h5py.check_enum_dtype(bodies["shape"].dtype)
            places = [file[f"parameters/shapes/{name}"] for name in sorted(number, key=number.get)]
            self.centers = [place["centers"][:].reshape(-1, 3) for place in places]
            self.radii = [place["radii"][:] for place in places]

    def spheres(self, shape):
        """The body of each sphere, by its place in `shape`; its centre and radius over the body's
        radius, in body axes."""
        counts = np.array([len(radii) for radii in self.radii])[shape]
        centers = [self.centers[s] for s in shape]
        radii = [self.radii[s] for s in shape]
        return (np.repeat(np.arange(len(shape)), counts), np.concatenate(centers),
                np.concatenate(radii))


def shape_of(bodies, rows):
    """The numbers of the shapes of these rows; 0 is the sphere."""
    return bodies["shape"][:][rows] if "shape" in bodies else np.zeros(len(rows), int)


def turned(orientation, v):
    """Vectors turned by unit quaternions x, y, z, w, a row each."""
    axis, w = orientation[:, :3], orientation[:, 3:]
    across = 2 * np.cross(axis, v)
    return v + w * across + np.cross(axis, across)
