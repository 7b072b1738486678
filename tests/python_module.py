"""The Python module: what it says of a scene is what the scene does, on any number of ranks.

SPDX-License-Identifier: BSD-3-Clause
usage: python_module.py CASES, in a folder to write in; under mpirun, with the module in PYTHONPATH
"""
import gc
import math
import os
import pathlib
import sys
import tomllib
import types
import unittest

from mpi4py import MPI
import numpy as np

import spall
from spall.toml import to_toml

comm = MPI.COMM_WORLD
cases = sys.argv.pop(1)
ROCK = {"materials": {"rock": {"density": 2000}}, "contact": {"friction": 0.5, "restitution": 0.3}}


def one_phase(step, duration, **keys):
    return [{"name": "only", "step": step, "duration": duration, **keys}]


def apart(step):
    """Four spheres that stay where they are."""
    sim = spall.Simulation(**ROCK, phases=one_phase(step, 1))
    for k in range(4):
        sim.add("rock", 0.5, position=(2 * k, 0, 0))
    return sim


def by_id(simulation, field):
    """A field of all bodies, on every rank."""
    bodies = simulation.bodies
    ids = np.concatenate(comm.allgather(np.array(bodies.id)))
    rows = np.concatenate(comm.allgather(np.array(getattr(bodies, field))))
    return rows[np.argsort(ids)]


class Module(unittest.TestCase):
    def test_mpi_is_that_of_mpi4py(self):
        self.assertEqual((spall.rank(), spall.ranks()), (comm.rank, comm.size))

    def test_spheres_fall_as_they_must_and_stay_where_the_module_says(self):
        sim = spall.Simulation(**ROCK, gravity={"uniform": [0, 0, -9.81]},
                               phases=one_phase(1e-3, 1))
        for k in range(6):
            sim.add("rock", 0.5, position=(2 * k, 0, 0), velocity=(0, 0, 1))
        sim.run_until(0.5)
        self.assertEqual((sim.steps, sim.phase, sim.over), (500, "only", False))
        self.assertAlmostEqual(sim.time, 0.5, places=12)
        # To half a step of gravity, by which velocities are behind.
        np.testing.assert_allclose(by_id(sim, "velocity"), [[0, 0, 1 - 9.81 * 0.5]] * 6,
                                   atol=1.001 * 9.81 * 1e-3 / 2)
        np.testing.assert_allclose(by_id(sim, "mass"), 2000 * math.pi / 6, rtol=1e-12)
        sim.run_until(10)
        self.assertTrue(sim.over)
        self.assertEqual(sim.steps, 1000)

    def test_any_number_of_ranks_makes_the_bodies_of_one(self):
        """One rank leaves its bodies in a file for the others: CTest runs it first."""
        tolerance, duration, file = 1e-8, 1000, "python_bodies_of_one_rank.npz"
        sim = spall.Simulation(f"{cases}/hello/case.toml", set={
            "solver.tolerance": tolerance, "groups.cloud.packing.count": 60,
            "groups.cloud.volume.radius": "6 m"})
        sim.run_until(duration)
        found = {name: by_id(sim, name)
                 for name in ("mass", "radius", "position", "velocity", "angular_velocity")}
        pairs = np.sort(np.concatenate(comm.allgather(sim.pairs())), axis=1)
        found["pairs"] = pairs[np.lexsort(pairs.T)]
        if comm.size == 1:
            np.savez(file, **found)
        expected = np.load(file)
        # Boulders have met, and are not yet a pile, whose chains of collisions would multiply the
        # least difference.
        self.assertGreater(len(found["pairs"]), 30)
        for name in ("mass", "radius", "pairs"):
            np.testing.assert_array_equal(found[name], expected[name])
        # Solved to a share of the speed, of which each of the few collisions of a boulder makes a
        # few more.
        speed = 10 * tolerance * np.abs(expected["velocity"]).max()
        for name, most in (("velocity", speed),
                           ("angular_velocity", speed / expected["radius"].min()),
                           ("position", speed * duration)):
            np.testing.assert_allclose(found[name], expected[name], rtol=0, atol=most)

    def test_own_forces_do_what_gravity_does(self):
        def fall(own):
            gravity = {} if own else {"gravity": {"uniform": [0, 0, -9.81]}}
            sim = spall.Simulation(**ROCK, **gravity, planes=[{"point": [0, 0, -0.6]}],
                                   phases=one_phase(1e-3, 1))
            for k in range(4):
                sim.add("rock", 0.5, position=(0.1 * k, 0, 1.1 * k))
            if own:
                def weight(bodies, forces):
                    forces[:, 2] -= 9.81 * bodies.mass
                sim.add_force(weight)
            sim.run_until(0.3)
            return by_id(sim, "position")

        # To half a step, by which the one begins earlier than the other.
        np.testing.assert_allclose(fall(True), fall(False), atol=9.81 * 1e-3 * 0.3)

    def test_own_forces_know_what_time_it_is(self):
        smooth = [{"name": "smooth", "method": "penalty", "step": 1e-3, "duration": 1}]
        sim = spall.Simulation(**ROCK, phases=smooth,
                               penalty={"model": "hooke", "stiffness": 1e6})
        for k in range(4):
            sim.add("rock", 0.5, position=(2 * k, 0, 0))
        times = []
        sim.add_force(lambda bodies, forces: times.append(sim.time))
        while sim.time < 0.0195:
            sim.step(100)
        self.assertEqual(len(set(times)), 20)

    def test_each_is_called_after_whole_numbers_of_steps(self):
        for steps in (0, 2.5, 0.3 / 0.1):
            with self.assertRaisesRegex(ValueError, "a whole number is wanted"):
                apart(1e-2).run_until(0.1, each=lambda sim: None, steps=steps)

    def test_a_force_that_is_returned_is_refused(self):
        sim = apart(1e-2)
        sim.add_force(lambda bodies, forces: np.ones(forces.shape))
        with self.assertRaisesRegex(TypeError, "write into forces"):
            sim.step()

    def test_forces_that_are_kept_stay_what_they_were(self):
        sim = apart(1e-2)
        kept = []

        def push(bodies, forces):
            forces[:, 0] += bodies.mass
            kept.append((forces, forces.copy()))

        sim.add_force(push)
        sim.add_force(push)  # adds to what the first has written
        for _ in range(5):
            sim.step()
        self.assertEqual(len(kept), 10)
        for forces, then in kept:
            self.assertTrue(forces.flags.owndata)
            np.testing.assert_array_equal(forces, then)
        np.testing.assert_allclose(by_id(sim, "velocity")[:, 0], 2 * 0.05, rtol=1e-12)

    def test_arrays_are_views_that_only_change_bodies_may_write(self):
        sim = spall.Simulation(**ROCK, phases=one_phase(1e-2, 1))
        for k in range(8):
            sim.add("rock", 0.5, position=(2 * k, 0, 0))
        if len(sim.bodies) > 0:
            with self.assertRaises(ValueError):
                sim.bodies.velocity[0] = 1
            self.assertTrue(np.shares_memory(sim.bodies.position, sim.bodies.position))

        def push(bodies):
            bodies.velocity[:, 1] = bodies.id
            with self.assertRaises(ValueError):
                bodies.id[:] = 0

        def forgotten(bodies):
            bodies.velocity = 2 * bodies.velocity

        with self.assertRaisesRegex(AttributeError,
                                    r"in change_bodies write bodies.velocity\[:\] = "):
            sim.change_bodies(forgotten)
        sim.change_bodies(push)
        sim.run_until(1)
        np.testing.assert_allclose(by_id(sim, "position")[:, 1], np.arange(8.0), rtol=1e-12,
                                   atol=1e-12)
        kinetic = 0.5 * 2000 * math.pi / 6 * sum(k * k for k in range(8))
        self.assertAlmostEqual(sim.energies()["kinetic"] / kinetic, 1, places=12)
        with self.assertRaisesRegex(AttributeError, "bodies have no mas; they have id,"):
            sim.bodies.mas
        kept = []
        sim.change_bodies(kept.append)
        if len(kept[0]) > 0:
            with self.assertRaises(ValueError):  # when the call is over, they are as others
                kept[0].velocity[0] = 1
            self.assertTrue(np.shares_memory(kept[0].velocity, sim.bodies.velocity))

    def test_what_is_kept_of_change_bodies_changes_nothing_later(self):
        sim = apart(1e-2)
        kept = []

        def push(bodies):
            bodies.velocity[:, 1] = 1
            self.assertIs(bodies.velocity, bodies.velocity)
            kept.extend([bodies.velocity, bodies.velocity[:]])

        sim.change_bodies(push)
        with self.assertRaises(ValueError):
            kept[0][:] = 1e6
        kept[1][:] = 1e6
        np.testing.assert_array_equal(by_id(sim, "velocity"), [[0, 1, 0]] * 4)

        def half(bodies):
            bodies.velocity[:] = 1e6
            raise KeyError("in the midst")

        with self.assertRaisesRegex(KeyError, "in the midst"):
            sim.change_bodies(half)

        def heavy(bodies):
            bodies.mass[:] = -1

        with self.assertRaisesRegex(spall.Error, r"change_bodies: body \d would have a mass"):
            sim.change_bodies(heavy)
        np.testing.assert_array_equal(by_id(sim, "velocity"), [[0, 1, 0]] * 4)
        sim.run_until(1)
        np.testing.assert_allclose(by_id(sim, "position")[:, 1], 1, rtol=1e-12)

    def test_memory_of_a_view_lives_as_long_as_the_view(self):
        sim = apart(1e-2)
        mass = sim.bodies.mass
        del sim
        gc.collect()
        np.testing.assert_allclose(mass, 2000 * math.pi / 6, rtol=1e-12)

    def test_callbacks_come_between_steps(self):
        sim = apart(1e-2)
        seen = []
        sim.run_until(0.25, each=lambda s: seen.append(s.steps), steps=10)
        self.assertEqual(seen, [10, 20])
        with self.assertRaisesRegex(ValueError, "each after 0 steps"):
            sim.run_until(0.5, each=seen.append, steps=0)
        with self.assertRaisesRegex(ValueError, "each, which is not given"):
            sim.run_until(0.5, steps=10)

    def test_errors_say_what_is_wrong_where(self):
        with self.assertRaisesRegex(TypeError, "contact.friction is None"):
            spall.Simulation(f"{cases}/hello/case.toml", set={"contact.friction": None})
        with self.assertRaisesRegex(spall.Error, "did you mean contact.friction"):
            spall.Scene(**{**ROCK, "contact": {"friktion": 0.5}}, phases=one_phase(1, 1))
        with self.assertRaisesRegex(spall.Error, "before a simulation begins"):
            sim = apart(1e-2)
            sim.step()
            sim.add("rock", 0.5, position=(9, 0, 0))
        with self.assertRaisesRegex(TypeError, "a case and tables of one"):
            spall.Scene(f"{cases}/hello/case.toml", contact={})

    def test_pictures_draw_last_what_is_next_to_who_sees_their_axes_so(self):
        bodies = types.SimpleNamespace(position=[[1, 2, 3], [4, 5, 6]], radius=[1, 1],
                                       velocity=[[0, 0, 0], [0, 0, 1]])
        for along, last in (("x", 1), ("y", 0), ("z", 1)):
            disks = spall.draw(bodies, "drawn.png", along=along).axes[0].collections[0]
            across = [k for k in range(3) if "xyz"[k] != along]
            np.testing.assert_array_equal(disks.get_offsets()[-1],
                                          np.array(bodies.position[last])[across])

    def test_tables_become_the_toml_that_they_are(self):
        tables = {"title": 'a "b"\\\n', "a b": {"x": 1, "y": [1.5, True], "z": {"u": 1e-300}},
                  "flag": False,
                  "rows": [{"k": 1, "inner": [{"q": "x"}]}, {"k": 2}], "empty": [], "none": {}}
        self.assertEqual(tomllib.loads(to_toml(tables)), tables)
        self.assertEqual(tomllib.loads(
            to_toml({"v": np.array([1.0, 2.0]), "n": np.int64(3), "b": np.bool_(True)})),
                         {"v": [1, 2], "n": 3, "b": True})

    def test_a_run_leaves_what_the_program_leaves(self):
        out = f"python_run_{comm.size}"
        scene = spall.Scene(**ROCK, gravity={"uniform": [0, 0, -9.81]}, phases=one_phase(1e-2, 1),
                            output={"series_every": 0.1},
                            groups=[{"name": name, "material": "rock", "volume": {
                                "shape": "sphere", "radius": 0.5, "center": [2 * x, 0, 0]}}
                                    for x, name in enumerate("abcd")])
        run = scene.run(out, overwrite=True)
        comm.barrier()
        self.assertEqual(run["solver"]["steps"], 100)
        self.assertEqual(run.series["step"].iloc[0], 0)
        frames = list(run.frames())
        self.assertEqual([frames[0][0], frames[0][1]["position"].shape], [0, (4, 3)])
        self.assertAlmostEqual(frames[-1][0], 1, places=12)
        np.testing.assert_allclose(frames[-1][1]["position"][:, 2], -9.81 / 2, rtol=0.02)
        with self.assertRaisesRegex(spall.Error, "overwrite"):
            scene.run(out)
        comm.barrier()
        self.assertEqual(spall.Run(out).results, run.results)
        self.assertIs(run.results, run.results)

    def test_spheres_of_a_program_spin_on_after_a_resume(self):
        out = f"python_spin_{comm.size}"
        law = {"law": "lennard_jones", "distance": 2, "depth": 1, "cutoff": 4}
        phases = [one_phase(1e-3, 1e-2)[0] | {"name": name, "method": "potential"}
                  for name in ("first", "second")]
        scene = spall.Scene(**ROCK, pair_potential=law, phases=phases)
        scene.add("rock", 1, spin=[0, 0, 5])
        for x in (10, 20, 30):
            scene.add("rock", 1, position=[x, 0, 0])
        run = scene.run(out, overwrite=True)
        comm.barrier()
        resumed = spall.resume(f"{out}/after_first.h5", f"{out}_resumed", overwrite=True)
        comm.barrier()
        self.assertGreater(run["conservation"]["kinetic"], 0)
        self.assertEqual(resumed["conservation"], run["conservation"])

    def test_a_case_that_has_changed_goes_on_as_it_was_where_asked(self):
        out = f"python_changed_{comm.size}"
        case = f"{out}.toml"

        def write(duration):
            if comm.rank == 0:
                pathlib.Path(case).write_text(
                    '[materials.rock]\ndensity = 2000\n[contact]\n' + "".join(
                        f'[[groups]]\nname = "{name}"\nmaterial = "rock"\nvolume = {{radius = 1, '
                        f'center = [{4 * k}, 0, 0]}}\n' for k, name in enumerate("abcd")) +
                    f'[[phases]]\nname = "one"\nstep = 1\nduration = 2\n'
                    f'[[phases]]\nname = "two"\nstep = 1\nduration = {duration}\n')
            comm.barrier()
        write(3)
        spall.run(case, out, overwrite=True)
        write(4)
        restart = f"{out}/after_one.h5"
        with self.assertRaisesRegex(spall.Error, "has changed since"):
            spall.resume(restart, f"{out}_resumed", overwrite=True)
        comm.barrier()
        run = spall.resume(restart, f"{out}_resumed", overwrite=True, stored_case=True)
        self.assertAlmostEqual(list(run.frames())[-1][0], 5)


class OthersScenes(unittest.TestCase):
    """Scenes that users of REBOUND asked about: issues 865, 817, 251 of hannorein/rebound."""

    def test_what_rests_does_not_sink(self):
        sim = spall.Simulation(**ROCK, gravity={"uniform": [0, 0, -9.81]}, planes=[{}],
                               phases=one_phase(1e-3, 20))
        for k in range(4):
            sim.add("rock", 0.1, position=(0, 0, 0.1 + 0.2 * k))
        sim.run_until(20)
        height = by_id(sim, "position")[:, 2]
        # The overlap of a contact that rests is what one step of gravity adds at most.
        np.testing.assert_allclose(height, [0.1, 0.3, 0.5, 0.7], atol=4 * 9.81 * 1e-3**2)
        self.assertLess(np.abs(by_id(sim, "velocity")).max(), 9.81 * 1e-3)

    def test_24_spheres_meet_one_at_the_same_instant(self):
        # The corners of a snub cube: their directions add up to nothing.
        t = (1 + (19 - 3 * math.sqrt(33)) ** (1 / 3) + (19 + 3 * math.sqrt(33)) ** (1 / 3)) / 3
        corner = np.array([1, 1 / t, t])
        corners = []
        for k in range(3):
            for signs in np.ndindex(2, 2, 2):
                even = sum(signs) % 2 == 0
                order = np.roll(corner, k) if even else np.roll(corner[[1, 0, 2]], k)
                corners.append(order * (1 - 2 * np.array(signs)))
        corners = np.array(corners) / np.linalg.norm(corner)
        self.assertLess(np.abs(corners.sum(axis=0)).max(), 1e-12)
        sim = spall.Simulation(materials=ROCK["materials"],
                               contact={"friction": 0.5, "restitution": 0.5},
                               phases=one_phase(1e-3, 1))
        sim.add("rock", 1)
        for x in corners:
            sim.add("rock", 0.3, position=1.32 * x, velocity=-x)
        before = sim.energies()["kinetic"]
        sim.run_until(1)
        speed = np.linalg.norm(by_id(sim, "velocity"), axis=1)
        self.assertLess(speed[0], 1e-2)
        # All leave with half of their speed, as one alone would from a wall; to the solver's
        # tolerance.
        np.testing.assert_allclose(speed[1:], 0.5, rtol=0.02)
        self.assertLess(sim.energies()["kinetic"], before)

    def test_a_rubble_pile_comes_to_rest(self):
        smaller = {"groups.cloud.packing.count": 60, "groups.cloud.volume.radius": "6 m"}
        sim = spall.Simulation(f"{cases}/hello/case.toml", set=smaller)
        while sim.phase == "aggregation" and not sim.over:
            sim.step()
        self.assertLess(np.linalg.norm(by_id(sim, "velocity")[:60], axis=1).max(), 1e-3)


if __name__ == "__main__":
    log = open(os.devnull, "w") if comm.rank else sys.stderr
    done = unittest.main(testRunner=unittest.TextTestRunner(stream=log), exit=False)
    failed = comm.allreduce(len(done.result.failures) + len(done.result.errors))
    if comm.rank and (done.result.failures or done.result.errors):
        for _, text in done.result.failures + done.result.errors:
            print(f"rank {comm.rank}: {text}", file=sys.stderr)
    sys.exit(1 if failed else 0)
