# What the report says of the inside of a pile, of crystals whose inside is known.
# SPDX-License-Identifier: BSD-3-Clause
"""report_interior.py FOLDER_OF_THE_REPORT, in a folder to write in."""
import pathlib
import sys
import tempfile
import types
import unittest

import h5py
import numpy as np

sys.path.insert(0, sys.argv.pop(1))
import report_interior  # noqa: E402
from report_interior import Inside, largest_voids, shared_volume  # noqa: E402

RADIUS, MASS, PULL, IMPULSE = 2.0, 3.0, 0.5, 7.0  # m, kg, 1/s^2, N s


def crystal(reach):
    """Centres of touching fcc spheres within `reach` of one of them."""
    n = np.arange(-6, 7)
    grid = np.stack(np.meshgrid(n, n, n, indexing="ij"), axis=-1).reshape(-1, 3)
    x = grid[grid.sum(axis=1) % 2 == 0] * np.sqrt(2) * RADIUS
    return x[np.linalg.norm(x, axis=1) <= reach]


def write(path, x, contacts=None):
    """A restart file: spheres drawn to their middle by PULL times their distance, the same impulse
    at every contact."""
    if contacts is None:
        apart = np.linalg.norm(x[:, None] - x[None], axis=2)
        contacts = np.argwhere(np.triu(np.abs(apart - 2 * RADIUS) < 1e-9 * RADIUS, 1))
    i, j = np.array(contacts).T
    normal = x[j] - x[i]
    # Rows lie as ranks left them; contacts name ids.
    shuffled = np.random.default_rng(1).permutation(len(x))
    with h5py.File(path, "w") as file:
        for key, values in (("id", np.arange(len(x))), ("position", x),
                            ("acceleration", -PULL * (x - x.mean(axis=0))),
                            ("radius", np.full(len(x), RADIUS)), ("mass", np.full(len(x), MASS))):
            file[f"bodies/{key}"] = values[shuffled]
        file["contacts/i"], file["contacts/j"] = i, j
        file["contacts/impulse"] = IMPULSE * normal / np.linalg.norm(normal, axis=1)[:, None]
    return path


class Interior(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.path = pathlib.Path(self.folder.name)

    def tearDown(self):
        self.folder.cleanup()

    def inside(self, x, contacts=None):
        return Inside(write(self.path / "state.h5", x, contacts), 1e-6 * RADIUS)

    def test_two_balls_share_what_their_lens_holds(self):
        r = np.array([RADIUS])
        whole = 4 / 3 * np.pi * RADIUS**3
        self.assertAlmostEqual(shared_volume(10, r, np.array([0.0]))[0], whole)
        self.assertEqual(shared_volume(10, r, np.array([12.0]))[0], 0)
        equal = np.pi / 12 * (4 * RADIUS + 1.5) * (2 * RADIUS - 1.5)**2  # of equal balls 1.5 apart
        self.assertAlmostEqual(shared_volume(RADIUS, r, np.array([1.5]))[0], equal)

    def test_a_crystal_is_as_dense_at_every_depth(self):
        state = self.inside(crystal(12))
        filled = state.profile(np.array([0.0, 9.0]))[0]
        # A ball of 4.5 radii cuts spheres at its rim.
        self.assertAlmostEqual(filled, np.pi / np.sqrt(18), delta=0.03)
        inner = np.linalg.norm(state.position, axis=1) < 12 - 2.1 * RADIUS
        self.assertTrue(np.all(state.coordination[inner] == 12))
        self.assertTrue(np.all(state.coordination <= 12))

    def test_equal_contacts_share_the_virial_equally(self):
        x = crystal(9)
        state = self.inside(x)
        held = PULL * MASS * np.sum((x - x.mean(axis=0))**2)  # sum of f d over contacts at rest
        np.testing.assert_allclose(state.force, held / (len(state.i) * 2 * RADIUS), rtol=1e-12)

    def test_moments_are_those_of_point_masses_and_balls(self):
        state = self.inside(np.array([[0, 0, 0], [2 * RADIUS, 0, 0]]))
        ball = 2 * 0.4 * MASS * RADIUS**2
        np.testing.assert_allclose(state.moments(),
                                   [ball, ball + 2 * MASS * RADIUS**2, ball + 2 * MASS * RADIUS**2])

    def test_only_what_touches_belongs_to_the_pile(self):
        x = np.array([[0, 0, 0], [2 * RADIUS, 0, 0], [10 * RADIUS, 0, 0], [0, 2.1 * RADIUS, 0]])
        state = self.inside(x, [(0, 1), (0, 3)])  # the gap of the last is open
        np.testing.assert_array_equal(state.clump, [True, True, False, False])

    def test_voids_are_the_holes_of_the_lattice_and_the_place_of_a_missing_sphere(self):
        x = crystal(12)
        hole = (np.sqrt(2) - 1) * RADIUS  # octahedral, the largest of fcc
        for spheres, largest in ((x, hole), (x[np.linalg.norm(x, axis=1) > RADIUS], RADIUS)):
            axis, distance = self.inside(spheres).distance_to_solid(141)
            step = axis[1] - axis[0]
            x, y, z = np.meshgrid(axis, axis, axis, indexing="ij")
            found = largest_voids(axis, distance, 7.0 - np.sqrt(x**2 + y**2 + z**2), 3)
            self.assertLess(abs(found[0] - largest), step)
            self.assertLess(abs(found[1] - hole), step)

    def test_outside_of_a_flat_pile_is_no_void(self):
        x = crystal(16)
        state = self.inside(x[np.abs(x[:, 2]) < 7])
        axis, distance = state.distance_to_solid(81)
        self.assertTrue(np.isinf(distance).any())
        found = largest_voids(axis, distance, state.room(axis, 0.85), 3)
        self.assertLess(abs(found[0] - (np.sqrt(2) - 1) * RADIUS), axis[1] - axis[0])

    def test_room_is_that_of_the_ellipsoid(self):
        n = np.linspace(-1, 1, 41)
        x = np.stack(np.meshgrid(n, n, n, indexing="ij"), axis=-1).reshape(-1, 3)
        x = x[np.linalg.norm(x, axis=1) < 1] * [30, 20, 10]
        state = self.inside(x, [(0, 1)])
        state.position, state.clump = x, np.ones(len(x), bool)
        state.radius, state.mass = np.full(len(x), 1e-3), np.ones(len(x))
        room = state.room(np.array([-15.0, 0.0, 15.0]), 1.0)
        self.assertAlmostEqual(room[1, 1, 1], 10, delta=0.2)
        self.assertAlmostEqual(room[2, 1, 1], 5, delta=0.2)
        self.assertLess(room[1, 1, 2], 0)

    def test_all_is_drawn_before_and_after(self):
        write(self.path / "after_settling.h5", crystal(9))
        write(self.path / "after_impact.h5", crystal(8))
        run = types.SimpleNamespace(folder=self.path,
                                    case={"gravity": {"method": "tree"},
                                          "phases": [{"name": "settling"},
                                                     {"name": "impact", "impactor": {}}]},
                                    before=types.SimpleNamespace(radius=np.array([RADIUS])),
                                    flight=np.array([1.0, 0, 0]),
                                    side_view=lambda: (np.array([0, 1.0, 0]),
                                                       np.array([0, 0, 1.0])))
        figure, states = report_interior.interior(run)
        self.assertEqual([name for name, _, _ in states], ["before the impact", "after it"])
        titles = [axes.get_title(loc="left") + axes.get_title() for axes in figure.axes]
        for wanted in ("Porosity in the plane z = 0, after it",
                       "Pushing contacts, before the impact", "Coordination", "Forces"):
            self.assertTrue(any(wanted in title for title in titles),
                            f"no panel '{wanted}' among {titles}")
        figure.savefig(self.path / "interior.png", dpi=40)
        rows = dict((row[0], row[1:]) for row in report_interior.table(states))
        self.assertEqual(rows["bodies in the largest clump"],
                         tuple(str(len(crystal(r))) for r in (9, 8)))
        with h5py.File(self.path / "after_impact.h5", "a") as file:
            shapes = np.zeros(len(crystal(8)), dtype=np.int32)
            file["bodies/shape"] = shapes
        self.assertIsNotNone(report_interior.interior(run), "all of them are spheres")
        with h5py.File(self.path / "after_impact.h5", "a") as file:
            file["bodies/shape"][3] = 1
        self.assertIsNone(report_interior.interior(run), "clumps are no balls of their radius")

    def test_other_forces_than_own_gravity_leave_the_virial_nothing_to_tell(self):
        write(self.path / "after_rest.h5", crystal(9))

        def of(gravity, **phase):
            case = {"gravity": gravity, "phases": [{"name": "rest", **phase}]}
            run = types.SimpleNamespace(folder=self.path, case=case)
            run.before = types.SimpleNamespace(radius=np.array([RADIUS]))
            run.flight = np.array([1.0, 0, 0])
            run.side_view = lambda: (np.array([0, 1.0, 0]), np.array([0, 0, 1.0]))
            return report_interior.interior(run)
        self.assertIsNotNone(of({"method": "direct"}))
        self.assertIsNone(of({}))
        self.assertIsNone(of({"method": "direct", "uniform": [0, 0, -1]}))
        self.assertIsNone(of({"method": "direct"}, method="penalty"))

    def test_contacts_that_two_ranks_have_told_count_once(self):
        pairs = [(0, 1), (0, 2)]
        x = np.array([[0.0, 0, 0], [2 * RADIUS, 0, 0], [0, 2 * RADIUS, 0]])
        once, twice = self.inside(x, pairs), self.inside(x, [*pairs, pairs[1]])
        np.testing.assert_array_equal(once.coordination, twice.coordination)
        np.testing.assert_array_equal(once.force, twice.force)


if __name__ == "__main__":
    unittest.main()
