# What a picture of a report shows in each of its pixels, beside each sphere by itself.
# SPDX-License-Identifier: BSD-3-Clause
"""report_spheres.py FOLDER_OF_THE_REPORT"""
import sys
import unittest

import numpy as np

sys.path.insert(0, sys.argv.pop(1))
from report_spheres import Camera, depth_buffer  # noqa: E402

CAMERA = Camera(np.array([1.0, 2, 3]), np.array([0.0, 0, 1]), np.array([5.0, 6, 7]), 8, 6, 160)


def by_brute_force(position, radius):
    """Depths and owners where lines through the pixels' middles meet spheres first."""
    pixel = CAMERA.width / CAMERA.columns
    x = (np.arange(CAMERA.columns) + 0.5) * pixel - CAMERA.width / 2
    y = CAMERA.height / 2 - (np.arange(CAMERA.rows) + 0.5) * pixel
    through = CAMERA.center + (x[None, :, None] * CAMERA.right
                               + y[:, None, None] * CAMERA.up)
    depth = np.full(through.shape[:2], -np.inf)
    owner = np.full(depth.shape, -1)
    for k, (center, r) in enumerate(zip(position, radius)):
        apart = through - center
        along = apart @ CAMERA.toward
        inside = r ** 2 - (apart ** 2).sum(axis=2) + along ** 2
        surface = np.where(inside > 0, np.sqrt(np.maximum(inside, 0)) - along, -np.inf)
        nearer = surface > depth
        depth[nearer], owner[nearer] = surface[nearer], k
    return depth, owner


class Spheres(unittest.TestCase):
    def compare(self, position, radius, within=1e-12):
        depth, owner = depth_buffer(CAMERA, position, radius)
        expected, first = by_brute_force(position, radius)
        np.testing.assert_array_equal(owner, first)
        np.testing.assert_allclose(depth, expected, rtol=0, atol=within * CAMERA.width)
        return owner

    def test_many_of_all_sizes_some_beyond_the_edges(self):
        random = np.random.default_rng(2)
        radius = 10 ** random.uniform(-2.5, 0.3, 600)
        position = CAMERA.center + random.uniform(-6, 6, (len(radius), 3))
        owner = self.compare(position, radius)
        self.assertGreater(len(np.unique(owner)), 50)
        self.assertGreater(len(np.unique(radius[owner[owner >= 0]] // 0.05)), 5)

    def test_equal_ones_to_their_rims(self):
        random = np.random.default_rng(3)
        for size in (0.07, 0.14, 0.345):
            self.compare(CAMERA.center + random.uniform(-4, 4, (40, 3)), np.full(40, size))

    def test_one_that_is_wider_than_the_picture_hides_all_behind(self):
        position = CAMERA.center + np.array([[-9, 0, 0], [9, 0, 0]]) @ np.array(
            [CAMERA.toward, CAMERA.right, CAMERA.up])
        position = np.vstack([position, CAMERA.center - 12 * CAMERA.toward])
        self.compare(position, np.array([8.0, 8.0, 1.0]))

    def test_a_planet_takes_no_more_than_the_picture(self):
        planet, moon = CAMERA.center - 1e6 * CAMERA.toward, CAMERA.center + 2 * CAMERA.right
        # Of a planet's radius; at a rim the root of what is left of it makes round-off larger.
        within = 1e-11 * 1e6 / CAMERA.width
        owner = self.compare(np.stack([planet, moon]), np.array([1e6, 1.0]), within)
        self.assertEqual(set(np.unique(owner)), {0, 1})
        self.compare(np.stack([planet - 1e6 * CAMERA.right, moon]), np.array([1.4e6, 1.0]),
                     1.4 * within)

    def test_none_and_none_in_sight(self):
        for position in (np.zeros((0, 3)), CAMERA.center + 50 * CAMERA.up[None, :]):
            owner = self.compare(position, np.ones(len(position)))
            self.assertTrue(np.all(owner == -1))


if __name__ == "__main__":
    unittest.main()
