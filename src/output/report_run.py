# What a run has left in its folder so far, whether it has ended or is still under way.
# SPDX-License-Identifier: BSD-3-Clause
import functools
import glob
import os
import re
import socket
import sys
import tomllib

import h5py
import numpy as np

from report_clumps import Shapes, shape_of, turned

GRAVITY = 6.67430e-11
ROUND_OFF = 1e-9  # of sums of steps


def readable_time(seconds):
    if seconds == 0:
        return "0 s"
    for limit, unit, name in ((1e-3, 1e-6, "µs"), (1, 1e-3, "ms"), (120, 1, "s"),
                              (7200, 60, "min")):
        if abs(seconds) < limit * (1 - 1e-9):  # round-off: 1 s is one
            return f"{seconds / unit:.3g} {name}"
    return f"{seconds / 3600:.3g} h"


def readable_length(meters):
    for limit, unit, name in ((1e-3, 1e-6, "µm"), (1, 1e-3, "mm"), (1e3, 1, "m")):
        if meters < limit * (1 - 1e-9):  # round-off: 1 mm is one
            return f"{meters / unit:.3g} {name}"
    return f"{meters / 1e3:.3g} km"


def has_ended(process):
    """Whether the process of this machine is gone, or was killed and nobody has asked how."""
    try:
        os.kill(process, 0)
        with open(f"/proc/{process}/stat", encoding="utf-8") as file:
            return file.read().rpartition(") ")[2].startswith("Z")
    except ProcessLookupError:
        return True
    except OSError:
        return False


class Frame:
    """The bodies that are there at one time."""

    def __init__(self, time, position, velocity, radius, mass, group, spheres=None):
        self.time, self.position, self.velocity = time, position, velocity
        self.radius, self.mass, self.group = radius, mass, group
        # Of each sphere that is drawn: its body, place and radius.
        self.spheres = spheres or (np.arange(len(radius)), position, radius)

    def without(self, body):
        keep = np.arange(len(self.radius)) != body
        number = np.cumsum(keep) - 1
        of, position, radius = self.spheres
        drawn = of != body
        return Frame(self.time, self.position[keep], self.velocity[keep], self.radius[keep],
                     self.mass[keep], self.group[keep],
                     (number[of[drawn]], position[drawn], radius[drawn]))


class GravityMap:
    """Gravity's field on a grid of points, as a snapshot holds it: indices are x, y, z."""

    def __init__(self, group):
        self.counts = group["counts"][:]
        self.low, self.spacing = np.ravel(group["low"]), float(group["spacing"][0])
        shape = tuple(self.counts[::-1])
        self.potential = group["potential"][:].reshape(shape).T
        self.acceleration = np.moveaxis(group["acceleration"][:].reshape(*shape, 3).T, 0, -1)


class Series:
    """The whole rows of series.csv."""

    def __init__(self, path):
        self.path, self.names, self.rows, self.read = path, [], [], 0

    def update(self):
        """Reads the rows that were added since; whether there are any."""
        with open(self.path, "rb") as file:
            if os.fstat(file.fileno()).st_size < self.read:  # the run was begun again
                self.names, self.rows, self.read = [], [], 0
            file.seek(self.read)
            text = file.read()
        whole = text[:text.rfind(b"\n") + 1]
        self.read += len(whole)
        lines = whole.decode().splitlines()
        if lines and not self.names:
            self.names = lines.pop(0).split(",")
        if lines:
            self.rows.append(np.array([line.split(",") for line in lines], float))
        return bool(whole)

    def columns(self):
        table = np.concatenate(self.rows) if self.rows else np.zeros((0, len(self.names)))
        return dict(zip(self.names, table.T))


class Run:
    """What a run left in its folder. Frames are read when they are asked for."""

    def __init__(self, folder, program):
        self.folder, self.program = folder, program
        self.file("trajectory.h5")
        with h5py.File(os.path.join(folder, "snapshots", self.snapshots()[0])) as file:
            self.origin = {key: self.told(value) for key, value in file["parameters"].items()
                           if isinstance(value, h5py.Dataset)}
        self.case_text = self.origin.pop("case")
        self.case = self.case_as_run()
        self.flight = np.array([1.0, 0, 0])
        self.impactor_text, self.impact_phase = "", None
        for k, phase in enumerate(self.case.get("phases", [])):
            if "impactor" in phase:
                self.impact_phase = k
                flight = np.array(phase["impactor"].get("direction", [1, 0, 0]), float)
                self.flight = flight / np.linalg.norm(flight)
                parts = [phase["impactor"].get(key) for key in ("mass", "speed")]
                self.impactor_text = ", ".join(str(part) for part in parts if part is not None)
        self.rows, self.series = Series(self.file("series.csv")), {}
        self.update()
        if not self.rows.names:
            sys.exit(f"{program}: '{self.rows.path}' has no row yet")

    def case_as_run(self):
        """With what --set changed."""
        path = os.path.join(self.folder, "resolved_case.toml")
        if not os.path.exists(path):
            return tomllib.loads(self.case_text)
        with open(path, "rb") as file:
            return tomllib.load(file)

    @staticmethod
    def told(dataset):
        value = dataset[()]
        return value.decode() if isinstance(value, bytes) else np.ravel(value)[0].item()

    def update(self):
        """Reads what has come since."""
        if self.rows.update() or not self.series:
            self.series = self.rows.columns()
        self.results, self.notes = self.read_results()

    def file(self, name):
        path = os.path.join(self.folder, name)
        if not os.path.exists(path):
            sys.exit(
                f"{self.program}: '{path}' is missing: is '{self.folder}' the folder of a run?")
        return path

    def snapshots(self):
        """Names of the files, in order of time; a snapshot takes its name when it is whole."""
        places = glob.glob(os.path.join(glob.escape(self.folder), "snapshots", "*.h5"))
        found = [name for name in map(os.path.basename, places) if name[:-3].isdecimal()]
        if not found:
            sys.exit(f"{self.program}: '{self.folder}' has no snapshot yet")
        return sorted(found, key=lambda name: int(name[:-3]))

    @property
    def title(self):
        return self.case.get("title") or os.path.basename(os.path.abspath(self.folder))

    @property
    def under_way(self):
        """By the lock; what this machine's process left there, when it was killed, is none."""
        try:
            with open(os.path.join(self.folder, "lock"), encoding="utf-8") as file:
                host, process = file.read().split()
        except FileNotFoundError:
            return False
        except (OSError, ValueError):
            return True
        return host != socket.gethostname() or not has_ended(int(process))

    @functools.cached_property
    def frames(self):
        """The first one, the last before the impact, and the last; and the row of the impactor, or
        -1."""
        with h5py.File(self.file("trajectory.h5")) as file:
            all_bodies, shapes = file["particles/all"], Shapes(file)
            time = all_bodies["position/time"][:]
            before, impactor = 0, -1
            if self.impact_phase is not None:  # an impactor comes last, in a group of its own
                of_none = all_bodies["group"][:] == len(self.case.get("groups", []))
                if of_none[-1:].all() and of_none.sum() == 1:
                    impactor = len(of_none) - 1
                    place = all_bodies["position/value"][:, impactor, 0]
                    # A run that goes on from a restart file may have it from its first snapshot on.
                    before = max(0, int(np.argmax(~np.isnan(place))) - 1)
            before, after = (self.frame(all_bodies, k, time, shapes)
                             for k in (before, len(time) - 1))
            if len(before.radius) > impactor >= 0:
                before = before.without(impactor)
        return before, after, impactor

    before = property(lambda self: self.frames[0])
    after = property(lambda self: self.frames[1])
    impactor = property(lambda self: self.frames[2])
    has_impact = property(lambda self: self.impactor >= 0)

    @functools.cached_property
    def gravity(self):
        with h5py.File(os.path.join(self.folder, "snapshots", self.snapshots()[-1])) as file:
            return GravityMap(file["fields/gravity"]) if "fields/gravity" in file else None

    @functools.cached_property
    def size(self):
        pile = self.results.get("pile", {})
        return pile.get("mean_diameter") or 2 * np.linalg.norm(
            self.before.position - np.median(self.before.position, axis=0), axis=1).max()

    @staticmethod
    def frame(all_bodies, k, time, shapes):
        position = all_bodies["position/value"][k]
        there = ~np.isnan(position[:, 0])
        position, radius = position[there], all_bodies["radius"][:][there]
        of, centers, radii = shapes.spheres(shape_of(all_bodies, np.flatnonzero(there)))
        places = position[of]
        if len(of) > len(position):
            orientation = all_bodies["orientation/value"][k][there]
            places = places + radius[of, None] * turned(orientation[of], centers)
        return Frame(time[k], position, all_bodies["velocity/value"][k][there], radius,
                     all_bodies["mass"][:][there], all_bodies["group"][:][there],
                     (of, places, radius[of] * radii))

    def read_results(self):
        """Values, and the unit and note that stand behind each of them as a comment."""
        path = os.path.join(self.folder, "results.toml")
        if not os.path.exists(path):
            return {}, {}
        with open(path) as file:
            text = file.read()
        results, notes, section = tomllib.loads(text), {}, ""
        self.origin |= {key: value for key, value in results.pop("provenance", {}).items()
                        if key != "case"}
        for line in text.splitlines():
            if match := re.fullmatch(r"\[(\w+)\]", line):
                section = match[1]
            elif match := re.match(r"(\w+) = .*  # (.*)", line):
                notes[section, match[1]] = match[2]
        return results, notes

    def side_view(self):
        """Toward the viewer and up, so that the impactor flies from left to right."""
        up = np.array([0, 0, 1.0]) if abs(self.flight[2]) < 0.9 else np.array([0, 1.0, 0])
        up -= (up @ self.flight) * self.flight
        up /= np.linalg.norm(up)
        return np.cross(self.flight, up), up

    def name_of(self, frame):
        since = self.since_impact(frame)
        if since is None:
            return f"{readable_time(frame.time)} after the start"
        return f"{readable_time(since)} after the impact" if since > 0 else "before the impact"

    def since_impact(self, frame):
        """s; 0 before it, None where there is none. A run that went on from a state after it has no
        frame before."""
        impact = self.impact_time() if self.has_impact else None
        if impact is None:
            return None
        return frame.time - impact if frame.time > impact * (1 + ROUND_OFF) else 0

    def is_free(self):
        """Whether neither walls nor a uniform field act, so that momentum is kept; as
        add_conservation has it."""
        return not (any(walls in self.case for walls in ("planes", "boxes", "cylinders"))
                    or "uniform" in self.case.get("gravity", {}))

    def marked_speeds(self):
        from report_figures import BLUE, GREEN
        mass = self.before.mass[np.isfinite(self.before.mass)].sum()
        marks = []
        gravity = self.case.get("gravity", {})
        constant = gravity.get("constant", GRAVITY)
        if gravity.get("method", "none") != "none" and not isinstance(constant, str):  # with a unit
            marks.append((np.sqrt(4 * constant * mass / self.size), "escape", GREEN))
        if dv := self.results.get("deflection", {}).get("dv"):
            if dv > 0:
                marks.append((dv, "dv", BLUE))
        return marks

    def impact_time(self):
        """s, at which the impactor was added; None before. Restart files tell it; without them it
        is the first row of the series since."""
        if self.impact_phase is None:
            return None
        if self.impact_phase == 0:
            return 0.0
        ended = [f"after_{phase['name']}" for phase in self.case["phases"][self.impact_phase - 1:]]
        for name in (*ended, "restart"):
            try:
                with h5py.File(os.path.join(self.folder, name + ".h5")) as file:
                    (_, phase, _), (time, _, since) = (file[f"clock/{part}"][:]
                                                       for part in ("counts", "times"))
            except OSError:  # there is none, or it is being written
                continue
            if since >= 0 or phase == self.impact_phase:
                return float(time - max(since, 0))
        rows = np.flatnonzero(self.series["phase"] >= self.impact_phase)
        return float(self.series["time"][rows[0]]) if len(rows) else None
