# Bodies and rows as a page carries them: rounded, compressed, as text.
# SPDX-License-Identifier: BSD-3-Clause
"""The other half, which unpacks, is page/packed.js.

Places are rounded to a part of the smallest radius, fields to eight bits behind the leading one. An
array's bytes are sorted by their weight before they are compressed: those of high weight are nearly
all alike.
"""
import base64
import os
import re
import sys
import zlib

import h5py
import numpy as np

from report_clumps import Shapes, shape_of, turned

PARTS_OF_RADIUS = 64  # places are rounded to the smallest radius over this
MOST_BODIES = 100_000
MOST_PLACES = 1_000_000  # bodies times instants
MOST_ROWS = 4000  # of the series
ABSENT = -2**31  # the place of a body that is not there
HIDDEN = ("position", "id", "species", "orientation")
NAMES = {"velocity": "speed", "angular_velocity": "spin", "kick": "kick by potentials"}


def pack(values, kind):
    """Text of an array: its bytes by weight, deflated, in base64."""
    values = np.ascontiguousarray(values, dtype=kind)
    sorted_bytes = values.view(np.uint8).reshape(-1, values.itemsize).T
    return base64.b64encode(zlib.compress(sorted_bytes.tobytes(), 6)).decode()


def upper_half(values):
    """The upper 16 of a float's 32 bits, rounded to nearest."""
    bits = np.asarray(values, np.float32).view(np.uint32).astype(np.uint64)
    return ((bits + 0x7FFF + ((bits >> 16) & 1)) >> 16).astype(np.uint16)


def spread(count, most):
    """Indices of at most `most` of `count`, equally far apart, with the first and the last."""
    return np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(int))


def unit_of(dataset):
    unit = dataset.attrs.get("unit", b"")
    unit = unit.decode() if isinstance(unit, bytes) else unit
    return re.sub(r"[+-]\d",
                  lambda power: power[0].translate(str.maketrans("-123456789+",
                                                                 "⁻¹²³⁴⁵⁶⁷⁸⁹ ")).strip(), unit)


def newest_snapshot(run):
    """The last one that can be read, open."""
    for name in reversed(run.snapshots()):
        try:
            return h5py.File(os.path.join(run.folder, "snapshots", name))
        except OSError:
            continue
    sys.exit(f"{run.program}: no snapshot of '{run.folder}' can be read")


class Bodies:
    """Which bodies a page shows, what is fixed of them, and how their places are rounded."""

    def __init__(self, run):
        self.folder = os.path.join(run.folder, "snapshots")
        with newest_snapshot(run) as file:
            bodies = file["particles/all"]
            self.count = len(bodies["radius"])
            rows = spread(self.count, MOST_BODIES)
            self.bodies_shown = len(rows)
            # A body with a shape is shown by its spheres: each of them has the body's row.
            of, self.centers, radii = Shapes(file).spheres(shape_of(bodies, rows))
            self.rows = rows[of]
            self.has_shapes = len(of) > len(rows)
            self.centers *= bodies["radius"][:][self.rows][:, None]
            radius = bodies["radius"][:][self.rows] * radii
            place = bodies["position/value"][0]
            self.low = np.floor(np.nanmin(place, axis=0))
            extent = np.nanmax(place) - self.low.min()
            self.step = float(max(radius.min() / PARTS_OF_RADIUS, extent / 2**30))
            self.names = {key: self.names_of(bodies[key]) for key in ("group", "material")}
            self.fields = [{"name": key, "label": NAMES.get(key, key.replace("_", " ")),
                            "unit": unit_of(bodies[key]["value"])}
                           for key in bodies if isinstance(bodies[key], h5py.Group)
                           and "value" in bodies[key] and key not in HIDDEN]
            mass = bodies["mass"][:][self.rows]
            self.fixed = {"radius": pack(radius, "<f4"), "mass": pack(mass, "<f4"),
                          "id": pack(self.rows, "<i4"),
                          **{key: pack(bodies[key][:][self.rows], "<i4")
                             for key in ("group", "material")}}

    @staticmethod
    def names_of(dataset):
        kinds = h5py.check_enum_dtype(dataset.dtype) or {}
        return sorted(kinds, key=kinds.get)

    def shown(self, run):
        """The numbers of the snapshots that a page has room for: each, each second, fourth ... and
        the last."""
        numbers = [int(name[:-3]) for name in run.snapshots()]
        every = 1
        while len(numbers) / every * len(self.rows) > MOST_PLACES:
            every *= 2
        return sorted({*numbers[::every], numbers[-1]})

    def header(self):
        return {"count": len(self.rows), "shown": self.bodies_shown, "all": self.count,
                "low": self.low.tolist(), "step": self.step,
                "names": self.names, "fields": self.fields, "fixed": self.fixed}

    def frame(self, number):
        """One instant, or None where the file cannot be read."""
        try:
            with h5py.File(os.path.join(self.folder, f"{number:06}.h5")) as file:
                bodies = file["particles/all"]
                rows = self.rows[self.rows < len(bodies["radius"])]
                place = bodies["position/value"][0][rows]
                if self.has_shapes:
                    place = place + turned(bodies["orientation/value"][0][rows],
                                           self.centers[:len(rows)])
                there = np.isfinite(place).all(axis=1)
                steps = np.rint((place[there] - self.low) / self.step)
                places = np.full((len(self.rows), 3), ABSENT)
                places[:len(rows)][there] = np.clip(steps, -2**31 + 1, 2**31 - 1)
                fields = [self.field(bodies[field["name"]]["value"][0][rows])
                          for field in self.fields]
                return {"number": number, "time": float(bodies["position/time"][0]),
                        "middle": np.median(steps, axis=0).tolist(),
                        "position": pack(places, "<i4"), "fields": fields}
        except (OSError, KeyError):
            return None

    def field(self, values):
        """Vectors by their length. What is positive counts from the smallest, so that small
        differences stay."""
        values = np.linalg.norm(values, axis=1) if values.ndim == 2 else values.astype(float)
        offset = float(max(np.min(values, initial=np.inf, where=np.isfinite(values)), 0))
        offset = offset if np.isfinite(offset) else 0.0
        all_rows = np.full(len(self.rows), np.nan)
        all_rows[:len(values)] = values - offset
        return {"offset": offset, "values": pack(upper_half(all_rows), "<u2")}


def pack_series(run):
    """The rows of the series, thinned to what a picture can show."""
    count = len(run.series["time"])
    rows = spread(count, MOST_ROWS) if count else np.zeros(0, int)
    return {"columns": list(run.series), "rows": len(rows), "all": count,
            "values": pack(np.concatenate([values[rows] for values in run.series.values()]), "<f8")}
