# What a report carries and says, and what `spall watch` answers, without a browser.
# SPDX-License-Identifier: BSD-3-Clause
"""report.py SPALL SOURCE, in a folder to write in."""
import json
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import time
import types
import unittest
import urllib.error
import urllib.request
import zlib
from base64 import b64decode
from pathlib import Path

import h5py
import numpy as np

SPALL, SOURCE = (Path(argument).resolve() for argument in (sys.argv.pop(1), sys.argv.pop(1)))
sys.path[:0] = [str(SOURCE / "src" / "output")]
import report_bodies  # noqa: E402
import report_film  # noqa: E402
import report_page  # noqa: E402
import report_shields  # noqa: E402
import report_verdict  # noqa: E402
from report_run import Run, readable_length  # noqa: E402

WORK = Path("report_of_runs")


def make_run(name, *changes):
    """A small case, in a second."""
    subprocess.run([SPALL, "run", SOURCE / "cases/hello/case.toml", "--out", WORK / name,
                    "--overwrite", "--set",
                    "groups.cloud.packing.count=40", "groups.cloud.volume.radius=6",
                    "phases.aggregation.duration=1200",
                    *changes], check=True, stdout=subprocess.DEVNULL)
    return WORK / name


def unpack(text, kind):
    """What page/packed.js does."""
    sorted_bytes = np.frombuffer(zlib.decompress(b64decode(text)), np.uint8)
    size = np.dtype(kind).itemsize
    return np.ascontiguousarray(sorted_bytes.reshape(size, -1).T).view(kind).ravel()


def data_of(page):
    return json.loads(re.search(r"<script type=application/json id=data>(.*?)</script>",
                                page.read_text())[1])


class Page(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = make_run("one")
        subprocess.run([SPALL, "report", cls.folder], check=True, stdout=subprocess.DEVNULL)
        cls.page = cls.folder / "report.html"

    def test_places_and_fields_are_those_of_the_snapshots_within_what_the_page_says(self):
        run = data_of(self.page)["runs"][0]
        self.assertIs(run["free"], True)
        header = run["bodies"]
        self.assertEqual(len(run["frames"]), 4)
        for frame in run["frames"]:
            with h5py.File(self.folder / "snapshots" / f"{frame['number']:06}.h5") as file:
                bodies = file["particles/all"]
                there = len(bodies["radius"])
                self.assertAlmostEqual(frame["time"], bodies["position/time"][0])
                place = unpack(frame["position"], "<i4").reshape(-1, 3)
                self.assertTrue((place[there:] == report_bodies.ABSENT).all())
                apart = header["low"] + place[:there] * header["step"] - bodies["position/value"][0]
                self.assertLess(np.abs(apart).max(), 0.501 * header["step"])
                for field, packed in zip(header["fields"], frame["fields"]):
                    upper = unpack(packed["values"], "<u2").astype(np.uint32) << 16
                    shown = upper.view(np.float32)[:there].astype(float) + packed["offset"]
                    written = bodies[field["name"] + "/value"][0]
                    written = np.linalg.norm(written, axis=1) if written.ndim == 2 else written
                    np.testing.assert_allclose(shown, written, rtol=2**-8)
        smallest = unpack(header["fixed"]["radius"], "<f4").min()
        self.assertLessEqual(header["step"], smallest / report_bodies.PARTS_OF_RADIUS)

    def test_the_series_is_whole(self):
        series = data_of(self.page)["runs"][0]["series"]
        rows = np.loadtxt(self.folder / "series.csv", delimiter=",", skiprows=1)
        np.testing.assert_array_equal(unpack(series["values"], "<f8").reshape(-1, series["rows"]).T,
                                      rows)

    def test_a_run_that_goes_on_after_the_impact_with_other_keys_is_seen_as_it_was_run(self):
        subprocess.run([SPALL, "resume", self.folder / "after_aggregation.h5", "--out", WORK / "on",
                        "--overwrite", "--set", "phases.impact.impactor.direction=[0,0,1]",
                        "phases.impact.impactor.speed=2 km/s"],
                       check=True, stdout=subprocess.DEVNULL)
        run = Run(WORK / "on", "test")
        self.assertTrue(run.has_impact)
        self.assertEqual((len(run.before.radius), len(run.after.radius), run.impactor),
                         (40, 41, 40))
        np.testing.assert_array_equal(run.flight, [0, 0, 1])
        whole = Run(self.folder, "test")
        self.assertEqual(whole.name_of(whole.before), "before the impact")
        self.assertEqual(whole.impact_time(), whole.before.time)
        # Rare rows of the series tell no impact; a run that goes on knows no state before it.
        self.assertAlmostEqual(run.impact_time(), whole.impact_time())
        self.assertEqual(run.name_of(run.before), "100 ms after the impact")
        subprocess.run([SPALL, "resume", WORK / "on" / "after_impact.h5", "--out", WORK / "later",
                        "--overwrite", "--set", "output.series_every=5 s",
                        "output.snapshot_every=5 s"],
                       check=True, stdout=subprocess.DEVNULL)
        later = Run(WORK / "later", "test")
        self.assertAlmostEqual(later.impact_time(), run.impact_time())
        self.assertEqual([later.name_of(frame) for frame in (later.before, later.after)],
                         ["5 s after the impact", "10 s after the impact"])
        self.assertIn("2 km/s", run.impactor_text)

    def test_it_names_what_made_the_run(self):
        text = self.page.read_text()
        version = subprocess.run([SPALL, "--version"], capture_output=True, text=True,
                                 check=True).stdout.split()[1].rstrip(",")
        self.assertRegex(text, rf"version<td>{re.escape(version)}<")
        self.assertRegex(text, r"ranks<td>1<")
        self.assertIn("300 boulders", text)
        self.assertRegex(text, r"folder<td>/\S*report_of_runs/one<")

    def test_it_asks_for_nothing_from_elsewhere(self):
        text = re.sub(r"base64,[\w+/=]+", "", self.page.read_text())
        self.assertNotRegex(text, r"(src|href)=[\"']?https?:")

    def test_several_runs_stand_side_by_side(self):
        other = make_run("two", "contact.friction=0.1")
        subprocess.run([SPALL, "report", self.folder, other], check=True, stdout=subprocess.DEVNULL)
        text = (self.folder / "compared.html").read_text()
        self.assertEqual([run["name"] for run in data_of(self.folder / "compared.html")["runs"]],
                         ["one", "two"])
        self.assertIn("<th scope=col>one<th scope=col>two", text)

    def test_one_message_says_that_a_file_is_damaged(self):
        for name, content, words in (
                ("results.toml", b"[pile", f"a file of {WORK / 'damaged'} cannot be read"),
                ("trajectory.h5", b"not HDF5", f"a file of {WORK / 'damaged'} cannot be read"),
                ("series.csv", b"", f"'{WORK / 'damaged' / 'series.csv'}' has no row yet")):
            with self.subTest(name):
                copy = WORK / "damaged"
                shutil.rmtree(copy, ignore_errors=True)
                shutil.copytree(self.folder, copy)
                (copy / name).write_bytes(content)
                run = subprocess.run([SPALL, "report", copy], capture_output=True, text=True)
                self.assertNotEqual(run.returncode, 0)
                self.assertEqual(run.stderr.count("\n"), 1, run.stderr)
                self.assertIn(f"spall report: {words}", run.stderr)

    def test_more_bodies_than_a_page_has_room_for_are_thinned_and_that_is_said(self):
        most, report_bodies.MOST_BODIES = report_bodies.MOST_BODIES, 10
        try:
            run = Run(str(self.folder), "test")
            data = report_page.data_of(run, "one", report_bodies.Bodies(run), [])
        finally:
            report_bodies.MOST_BODIES = most
        self.assertEqual(data["bodies"]["count"], 10)
        # The impactor stays.
        self.assertEqual(list(unpack(data["bodies"]["fixed"]["id"], "<i4"))[-1], 40)
        self.assertIn("Of 41 bodies 10 are shown", report_page.footer([data]))


class Scenes(unittest.TestCase):
    """What fits one scene and misleads in another."""

    def of(self, **case):
        frame = types.SimpleNamespace(mass=np.array([3.0, np.inf]))
        return types.SimpleNamespace(case=case, results={}, before=frame, size=2.0)

    def test_momentum_drifts_where_nothing_acts_from_outside(self):
        self.assertTrue(Run.is_free(self.of(gravity={"method": "direct"})))
        self.assertFalse(Run.is_free(self.of(boxes=[{}])))
        self.assertFalse(Run.is_free(self.of(gravity={"uniform": [0, 0, -9.81]})))

    def test_what_does_not_attract_has_no_escape_speed(self):
        self.assertEqual(
            [name for _, name, _ in Run.marked_speeds(self.of(gravity={"method": "tree"}))],
            ["escape"])
        self.assertEqual(Run.marked_speeds(self.of(gravity={"uniform": [0, 0, -9.81]})), [])
        self.assertEqual(Run.marked_speeds(self.of()), [])


class Verdicts(unittest.TestCase):
    """Each sentence, and its grade, from results that are known."""

    def of(self, results, overlap=0.0, method="nonsmooth", under_way=False):
        run = types.SimpleNamespace(results=results, under_way=under_way,
                                    case={"phases": [{"method": method}]},
                                    series={"time": np.array([0.0, 3.0]),
                                            "overlap": np.array([0, overlap])})
        return {sentence: grade for grade, sentence in report_verdict.verdicts(run)}

    def check(self, found, grade, words):
        sentences = [sentence for sentence, one in found.items() if one == grade
                     and words in sentence]
        self.assertEqual(len(sentences), 1, f"{grade}: '{words}' in {found}")

    def test_a_run_without_results_has_not_ended(self):
        self.check(self.of({}), "bad", "has not ended")
        self.check(self.of({}, under_way=True), "note", "under way")

    def test_steps_that_did_not_converge_are_bad(self):
        solver = {"steps": 99, "solved_steps": 9, "steps_not_converged": 2, "residual_max": 1.0,
                  "steps_over_tolerance": 0}
        self.check(self.of({"solver": solver}), "bad", "2 of 9 steps did not converge")
        solver |= {"steps_not_converged": 0}
        self.check(self.of({"solver": solver}), "good", "All 9 steps converged")
        self.check(self.of({"solver": solver | {"steps_over_tolerance": 1}}), "note",
                   "missed the tolerance")
        self.check(self.of({"solver": {"steps": 9}}), "good", "smooth")

    def test_books_close_or_not(self):
        def books(**values):
            return self.of({"conservation": {"dissipated": 1.0, **values}})
        self.check(books(linear=1e-15, angular=1e-14), "good", "kept to round-off")
        self.check(books(linear=1e-15, angular=1e-6), "note", "by a tree")
        self.check(books(linear=1e-15, angular=1e-3), "bad", "not kept")
        self.check(books(linear=1e-6, angular=1e-15), "bad", "not kept")
        self.check(books(), "note", "Walls")
        for rest, grade in ((-0.009, "good"), (0.02, "note"), (-0.2, "bad")):
            self.check(books(energy_unexplained=rest), grade, "The energy account")
            self.check(books(energy_unexplained=rest, dissipated=0.0, energy_measure=2.0), grade,
                       "of the kinetic energy, as next to nothing")
        self.check(books(energy_unexplained=1e-9, dissipated=0.0, energy_measure=2.0, kinetic=0.0),
                   "good", "of what gravity gives in a step, as bodies rest")
        lost = {"energy_unexplained": 1e-9, "dissipated": -40.0, "energy_measure": 280.0}
        self.check(books(**lost), "good", "as energy was gained and not dissipated")
        self.check(books(**lost, gained_by_restitution=44.0), "bad", "Hits gave 44 J to clumps")
        self.check(books(energy_unexplained=1e-9, dissipated=1e4, gained_by_restitution=44.0),
                   "note", "Hits gave 44 J to clumps, beside 1e+04 J")

    def test_beta_that_is_only_a_bounce_is_said_to_be_so(self):
        def beta(value, **more):
            return self.of(
                {"deflection": {"beta": 9.0, "beta_along": value, "dv_plastic": 2.0,
                                "dv_elastic": 2.6, **more}})
        self.check(beta(1.301), "note", "only 1 + e = 1.3")
        ejecta = {"dv_impactor": 2.0, "dv_ejecta": 1.4}
        self.check(beta(2.0, **ejecta), "good", "ejecta carried off 0.7")
        coupled = {"deflection": {"beta_along": 1.38, "dv_plastic": 2.0, "dv_elastic": 2.6,
                                  "dv_impactor": 2.0, "dv_rebound": 0.5, "dv_ejecta": 0.26},
                   "coupling": {}}
        self.check(self.of(coupled), "good", "ejecta carried off 0.38")
        self.check(beta(1.1), "note", "less than")
        self.check(beta(1.4, warning="WARNING: beta 1.4 is that of a bounce alone"), "note",
                   "Beta 1.4 is that of a bounce alone.")
        self.check(beta(2.0, momentum_closure=1e-3, **ejecta), "bad", "miss its sum")
        self.check(beta(2.0, foreign_motion="a wall moves the target, too"), "bad",
                   "Beta is 2, but a wall moves the target, too.")
        self.check(beta(2.0, rigid_share=0.031, struck_mass=2500.0, **ejecta), "good",
                   "leaves 3.1 % of the impactor's energy in the body of 2.5e+03 kg")

    def test_a_deflection_that_still_rises_is_said_to_do_so(self):
        self.check(self.of({"read_out": {"since_impact": [1.0, 2.0], "dv": [1.0, 1.2]}}), "note",
                   "still changed by 17 %")
        self.check(self.of({"read_out": {"since_impact": [1.0, 2.0], "dv": [1.0, 1.001]}}), "good",
                   "come to rest")

    def test_walls_have_their_verdicts(self):
        def wall(verdict, **more):
            table = {"wall": "rear", "verdict": verdict, "margin": 0.62, "thickness": 4.8e-3,
                     "hole": 9.1e-3, "openings": 2, "spall_mass": 2e-5,
                     "spall_pieces": 3, "spall_speed": 120.0, "still_coming": 1e-4,
                     "rim_mass": 1e-6, "least_spall": 4e-6,
                     "opening_at_edge": False, "spacing": 1e-3,
                     "times": [1e-6, 2e-6], "margins": [0.63, 0.62]}
            return self.of({"shield_rear": table | more}, method="solid")
        self.check(wall("held"), "good", "rear has held: where it is thinnest, 62 % of its 4.8 mm")
        self.check(wall("perforated"), "note", "2 openings of up to 9.1 mm")
        self.check(wall("detached spall"), "note", "0.02 g in 3 pieces leave its rear at 120 m/s")
        self.assertEqual(len(wall("held")), len(self.of({"solver": {}}, method="solid")) + 1)
        self.check(wall("held", still_coming=0.3), "note", "not final: 30 %")
        self.check(wall("held", margins=[0.8, 0.62]), "note",
                   "still changed from 0.8 to 0.62 of its thickness between 1 µs and 2 µs")
        self.check(wall("perforated", opening_at_edge=True), "note", "reaches its edge")
        self.check(wall("held", spacing=2e-3), "note", "2.4 spacings")
        self.check(wall("held", rim_mass=5e-6), "note", "which is not judged, has lost 0.005 g")
        self.check(wall("held", largest_met=2.0, largest_passed=3.0), "note",
                   "too narrow: a piece of 3 J flew past")
        coarse = {"coarse": True, "largest_met_diameter": 2.1e-3}
        self.check(wall("held", **coarse), "note", "a ball of 2.1 mm, and fewer than seven")
        self.assertEqual(len(wall("perforated", **coarse)), len(wall("perforated")))
        self.check(self.of({"penalty": {"overlap_max": 0.02}}, method="penalty"), "note",
                   "overlapped by up to 2 % of the smaller radius")
        self.check(self.of({"settling": {"warning": "phase a has not settled"}}), "note",
                   "Phase a has not settled")
        self.assertEqual(len(wall("perforated", still_coming=0.3)), len(wall("perforated")))
        self.assertEqual(len(wall("held", largest_met=3.0, largest_passed=2.0)), len(wall("held")))
        self.check(wall("held", wall="wall"), "good", "The wall has held")
        # Three layers, which in binary are below three by round-off alone.
        three = wall("held", thickness=1.2e-3, spacing=0.4e-3)
        self.assertEqual([one for one in three if "spacings" in str(one)], [])

    def test_lengths_have_the_units_that_a_reader_would_take(self):
        lengths = (2e-7, 5e-3, 0.001, 0.5, 1, 200, 1e3)
        self.assertEqual([readable_length(one) for one in lengths],
                         ["0.2 µm", "5 mm", "1 mm", "500 mm", "1 m", "200 m", "1 km"])

    def test_overlaps_of_rigid_bodies_tell_of_long_steps(self):
        self.check(self.of({}, overlap=0.02), "note", "overlapped by up to 2 %")
        self.check(self.of({}, overlap=0.001), "good", "short enough")
        # Rows of the series are some of the steps alone.
        self.check(self.of({"solver": {"steps": 9, "overlap_max": 0.3}}, overlap=0.001), "note",
                   "overlapped by up to 30 %")
        self.check(self.of({}, overlap=0.02, method="penalty"), "good", "limits of the force laws")


class Shields(unittest.TestCase):
    """Four bodies of a wall of 2 mm, and a ball of two that comes from 20 mm above at an angle."""
    RADIUS = 1e-3

    def run_of(self, velocity, of_wall=(0, 0, 0), begins=0.0, **wall):
        WORK.mkdir(exist_ok=True)
        position = np.array([[-5e-3, 0, 0], [0, 4e-3, 0], [0, -4e-3, 0], [5e-3, 0, 0],
                             [-4e-3, 0, 0.02], [-4e-3, 0, 0.022]])
        with h5py.File(WORK / "trajectory.h5", "w") as file:
            bodies = file.create_group("particles/all")
            bodies["group"] = [0, 0, 0, 0, 1, 1]
            bodies["mass"], bodies["radius"] = np.full(6, 2e-6), np.full(6, self.RADIUS)
            for name, first in (("position", position),
                                ("velocity", np.array([of_wall] * 4 + [velocity] * 2))):
                bodies[f"{name}/value"] = np.array([first, first], float)
            bodies["position/time"] = [begins, begins + 1e-6]
        return types.SimpleNamespace(folder=WORK, case={
            "groups": [{"name": "rear wall"}, {"name": "ball"}],
            "shields": [{"wall": "rear wall"} | wall]})

    def shield(self, velocity, **more):
        run = self.run_of(velocity, **more)
        with h5py.File(WORK / "trajectory.h5") as file:
            return report_shields.Shield(run, file["particles/all"])

    def test_depths_are_from_the_rear_of_the_wall_and_all_of_the_way_is_seen(self):
        for more in ({}, {"rear": [0, 0, -2]}, {"rear": [0.9, 0, -1]}):
            shield = self.shield([1000, 0, -5000], **more)
            np.testing.assert_allclose(shield.rear, [0, 0, -1], atol=1e-12)
            self.assertAlmostEqual(shield.zero, self.RADIUS)
            self.assertLess(shield.extent[0], -0.022 - 3 * self.RADIUS)
            self.assertGreater(shield.extent[1], 0)
            self.assertEqual(list(shield.flies), [False] * 4 + [True] * 2)

    def test_a_shield_that_flies_at_a_ball_at_rest_is_seen_in_its_own_frame(self):
        for velocity, of_wall in (([0, 0, 0], [-1000, 0, 5000]), ([1000, 0, -5000], [0, 0, 0])):
            shield = self.shield(velocity, of_wall=of_wall)
            np.testing.assert_allclose(shield.rear, [0, 0, -1], atol=1e-12)
            self.assertLess(shield.extent[0], -0.022)
            place = np.array([[0, 0, 0.01]]) + 2e-7 * np.array(of_wall)
            np.testing.assert_allclose(shield.map_of(np.repeat(place, 6, axis=0), 2e-7),
                                       shield.map_of(np.array([[0, 0, 0.01]] * 6), 0))

    def test_it_is_seen_from_beside_the_plane_of_flight(self):
        np.testing.assert_allclose(self.shield([3000, 0, -4000]).side, [1, 0, 0], atol=1e-12)

    def test_a_wide_wall_is_cut_off_at_twice_the_depth(self):
        run = self.run_of([0, 0, -5000])
        with h5py.File(WORK / "trajectory.h5", "r+") as file:
            file["particles/all/position/value"][:, 0, 0] = -5
            shield = report_shields.Shield(run, file["particles/all"])
        low, high, bottom, top = shield.extent
        self.assertLessEqual(top - bottom, 2 * (high - low) * (1 + 1e-12))
        self.assertTrue(bottom < -4e-3 < top)
        self.assertLess(report_shields.radiographs(run).get_size_inches()[1], 20)

    def test_where_nothing_flies_or_all_began_later_there_is_no_film(self):
        self.assertIsNone(report_shields.radiographs(self.run_of([0, 0, 0])))
        self.assertIsNone(report_shields.radiographs(self.run_of([0, 0, -5000], begins=1e-6)))

    def test_no_mass_is_lost_on_a_film(self):
        extent, pixel = (-1.0, 2.0, -1.5, 1.5), 0.1
        x, y = np.random.default_rng(1).uniform(-1, 1.4, (2, 500))
        mass = np.r_[np.full(499, 2.0), np.inf]  # what is fixed has none
        image = report_film.column_map(x, y, mass, extent, pixel)
        self.assertAlmostEqual(image.sum() * pixel**2, 998)


class UnderWay(unittest.TestCase):
    """By the lock, unless its process was here and is gone."""

    def test_a_run_that_was_killed_is_not_under_way(self):
        gone = subprocess.Popen(["true"])
        gone.wait()
        folder = WORK / "killed"
        folder.mkdir(exist_ok=True)
        run = types.SimpleNamespace(folder=folder)
        here = socket.gethostname()
        for lock, expected in ((f"elsewhere {gone.pid}", True), (f"{here} {os.getpid()}", True),
                               (f"{here} {gone.pid}", False), ("", True)):
            (folder / "lock").write_text(lock)
            self.assertEqual(Run.under_way.fget(run), expected, lock)
        (folder / "lock").unlink()
        self.assertFalse(Run.under_way.fget(run))


class Watch(unittest.TestCase):
    """A folder that grows, as that of a run under way does."""

    def setUp(self):
        whole = make_run("watched_whole")
        self.whole, self.folder = whole, WORK / "watched"
        shutil.rmtree(self.folder, ignore_errors=True)
        (self.folder / "snapshots").mkdir(parents=True)
        shutil.copy(whole / "trajectory.h5", self.folder)
        (self.folder / "lock").write_text("host 1\n")
        self.lines = (whole / "series.csv").read_text().splitlines(keepends=True)
        # The last is not whole yet.
        (self.folder / "series.csv").write_text("".join(self.lines[:4]) + self.lines[4][:20])
        self.give(0)
        self.process = subprocess.Popen([SPALL, "watch", self.folder, "--port", "0"],
                                        stdout=subprocess.PIPE, text=True)
        self.address = re.match(r"http://\S+", self.process.stdout.readline())[0]

    def tearDown(self):
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()
        self.process.stdout.close()

    def give(self, number):
        shutil.copy(self.whole / "snapshots" / f"{number:06}.h5", self.folder / "snapshots")

    def ask(self, name):
        with urllib.request.urlopen(self.address + name) as answer:
            return json.load(answer)

    def test_what_the_run_adds_is_there_within_seconds(self):
        state = self.ask("state")
        self.assertEqual((state["shown"], state["rows"], state["over"]), ([0], 3, False))
        (self.folder / "series.csv").write_text("".join(self.lines))
        self.give(1)
        (self.folder / "snapshots" / "000002.h5.unfinished").write_text("not yet")
        (self.folder / "lock").unlink()
        shutil.copy(self.whole / "results.toml", self.folder)
        time.sleep(2.1)
        state = self.ask("state")
        self.assertEqual((state["shown"], state["rows"], state["over"]),
                         ([0, 1], len(self.lines) - 1, True))
        self.assertEqual(self.ask("snapshots/1")["number"], 1)
        self.assertEqual(self.ask("series")["series"]["all"], len(self.lines) - 1)
        self.assertIn("Momentum is kept", self.ask("words")["summary"])

    def test_what_cannot_be_read_is_passed_over(self):
        self.give(1)
        (self.folder / "snapshots" / "000001.h5").write_bytes(b"no HDF5")
        time.sleep(2.1)
        for name in ("snapshots/1", "snapshots/7", "../series.csv", "nothing"):
            with self.subTest(name):
                try:
                    self.assertIsNone(self.ask(name))
                except urllib.error.HTTPError as error:
                    self.assertIn(error.code, (404, 503))
        self.assertIsNone(self.process.poll())
        os.remove(self.folder / "snapshots" / "000001.h5")
        time.sleep(2.1)
        self.assertEqual(self.ask("state")["shown"], [0])

    def test_control_c_ends_it_well(self):
        self.process.send_signal(signal.SIGINT)
        self.assertEqual(self.process.wait(10), 0)

    def test_others_cannot_reach_it_and_nothing_is_written(self):
        before = sorted(self.folder.rglob("*"))
        self.ask("state")
        self.assertEqual(sorted(self.folder.rglob("*")), before)
        port = int(self.address.split(":")[-1].strip("/"))
        listening = Path("/proc/net/tcp").read_text() + Path("/proc/net/tcp6").read_text()
        self.assertIn(f"0100007F:{port:04X} 00000000:0000 0A", listening)
        self.assertNotIn(f"00000000:{port:04X} 00000000:0000 0A", listening)

    def test_one_message_says_what_is_wrong(self):
        taken = socket.create_server(("127.0.0.1", 0))
        port = str(taken.getsockname()[1])
        for arguments, words in (([WORK / "gone"], "is missing: is"),
                                 ([self.folder, "--port", port], f"port {port} is taken"),
                                 ([self.folder, "--port", "70000"], "0 to 65535 is wanted")):
            with self.subTest(words):
                run = subprocess.run([SPALL, "watch", *arguments], capture_output=True, text=True,
                                     timeout=20)
                self.assertNotEqual(run.returncode, 0)
                self.assertEqual(run.stderr.count("\n"), 1, run.stderr)
                self.assertIn(words, run.stderr)
        taken.close()


if __name__ == "__main__":
    WORK.mkdir(exist_ok=True)
    unittest.main(verbosity=2)
