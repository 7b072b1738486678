#!/usr/bin/env python3
# Holds files against the H5MD 1.1 specification (https://h5md.nongnu.org/h5md.html).
# SPDX-License-Identifier: BSD-3-Clause
"""usage: h5md.py FILE…    H5MD or its XDMF index; fails with a line for each breach, prints
elements, frames, particles."""
import re
import sys
from pathlib import Path
from xml.etree import ElementTree

import h5py
import numpy as np

# A unit is a product: one number at most, symbols with powers other than zero, single spaces.
FACTOR = r"(?:\d+(?:\.\d+)?(?:[+-]\d+)?|[A-Za-zµ%]+(?:[+-][1-9]\d*)?)"
UNIT = re.compile(rf"{FACTOR}(?: {FACTOR})*")
# Floats without a unit.
PURE = {"damage", "phase", "contacts", "residual", "residual_prox", "products",
        "corrections_products", "overlap"}


class Checker:
    def __init__(self, path):
        self.path, self.breaches = path, []
        with h5py.File(path) as file:
            self.root(file)
            self.elements = 0
            for name, group in file.get("particles", {}).items():
                self.particles(name, group)
            for name, group in file.get("observables", {}).items():
                self.element(f"observables/{name}", group, units=True)

    def need(self, ok, what):
        if not ok:
            self.breaches.append(f"{self.path}: {what}")
        return ok

    def attribute(self, thing, key, shape, kinds):
        """The value of an attribute; None where it is missing or of another shape or kind."""
        if not self.need(thing is not None and key in thing.attrs,
                         f"{getattr(thing, 'name', '?')} has no attribute {key}"):
            return None
        found = thing.attrs.get_id(key)
        kind = "S" if h5py.check_string_dtype(found.dtype) else found.dtype.kind
        self.need(kind in kinds, f"attribute {thing.name}:{key} is of kind {kind}, not {kinds}")
        self.need(found.shape == shape,
                  f"attribute {thing.name}:{key} has the shape {found.shape}, not {shape}")
        return thing.attrs[key]

    def root(self, file):
        h5md = file.get("h5md")
        version = self.attribute(h5md, "version", (2,), "iu")
        self.need(version is not None and list(version) == [1, 1], "is not of version 1.1")
        self.attribute(h5md.get("author"), "name", (), "S")
        for key in ("name", "version"):
            self.attribute(h5md.get("creator"), key, (), "S")
        modules = h5md.get("modules", {})
        if self.need("units" in modules, "no module units"):
            self.attribute(modules["units"], "version", (2,), "iu")

    def unit(self, data, wanted):
        if wanted:
            self.need("unit" in data.attrs, f"{data.name} has no unit")
        if "unit" in data.attrs:
            text = self.attribute(data, "unit", (), "S")
            text = text.decode() if isinstance(text, bytes) else str(text)
            numbers = [factor for factor in text.split(" ") if factor[0].isdigit()]
            self.need(UNIT.fullmatch(text) and len(numbers) <= 1,
                      f"{data.name}: '{text}' is no unit")

    def element(self, name, thing, units=False):
        """Values of an element, with or without a dimension of time; None where it is broken."""
        self.elements += 1
        if isinstance(thing, h5py.Dataset):
            self.unit(thing, units and thing.dtype.kind == "f" and name.split("/")[-1] not in PURE)
            return thing
        for key in ("step", "value"):
            if not self.need(isinstance(thing.get(key), h5py.Dataset),
                             f"{name} has no dataset {key}"):
                return None
        step, value = thing["step"], thing["value"]
        frames = value.shape[0]
        self.need(step.dtype.kind in "iu" and step.shape == (frames,),
                  f"{name}/step does not count {frames} frames")
        self.need(np.all(np.diff(step[:]) > 0), f"{name}/step does not increase")
        if "time" in thing:
            time = thing["time"]
            self.need(time.shape == (frames,) and np.all(np.diff(time[:]) >= 0),
                      f"{name}/time does not go with its steps")
            self.unit(time, True)
        self.unit(value, units and value.dtype.kind == "f" and name.split("/")[-1] not in PURE)
        return value

    def particles(self, group_name, group):
        place = f"particles/{group_name}"
        box = group.get("box")
        dimension = self.attribute(box, "dimension", (), "iu")
        boundary = self.attribute(box, "boundary", (int(dimension),), "S")
        boundary = [b.decode() if isinstance(b, bytes) else str(b) for b in boundary]
        self.need(set(boundary) <= {"periodic", "none"}, f"{place}/box: boundary is {boundary}")
        if "edges" in box:
            edges = self.element(f"{place}/box/edges", box["edges"], units=True)
            self.need(edges.shape in ((dimension,), (dimension, dimension)),
                      f"{place}/box/edges has the shape {edges.shape}")
            for b, edge in zip(boundary, edges[:]):
                self.need(b != "periodic" or edge > 0,
                          f"{place}/box: a periodic direction has the edge {edge}")
        else:
            self.need("periodic" not in boundary, f"{place}/box is periodic and has no edges")
        self.need("position" in group, f"{place} has no position")
        rows, self.frames = None, None
        for name, thing in group.items():
            if name == "box" or (value := self.element(f"{place}/{name}", thing,
                                                       units=True)) is None:
                continue
            in_time = isinstance(thing, h5py.Group)
            rows = value.shape[in_time] if rows is None else rows
            self.need(value.shape[in_time] == rows,
                      f"{place}/{name} has {value.shape[in_time]} rows, not {rows}")
            if in_time:
                self.frames = value.shape[0]
            if name in ("position", "velocity", "force", "image"):
                self.need(value.shape[in_time + 1:] == (dimension,),
                          f"{place}/{name} is no vector of {dimension}")
            if name in ("species", "id"):
                self.need(value.dtype.kind in "iu",
                          f"{place}/{name} is neither integer nor enumeration")
        self.rows = rows
        self.masked(place, group)

    def masked(self, place, group):
        """A particle that is not there has the fill value for its id, and no position."""
        ids = group.get("id")
        if not isinstance(ids, h5py.Group):
            return
        for k, frame in enumerate(ids["value"][:]):
            there = frame != ids["value"].fillvalue if ids["value"].fillvalue != 0 else np.ones(
                len(frame), bool)
            self.need(len(np.unique(frame[there])) == there.sum(),
                      f"{place}/id: frame {k} has an id twice")
            known = ~np.isnan(group["position/value"][k]).any(axis=-1)
            self.need(np.array_equal(known, there),
                      f"{place}: frame {k} has positions of particles without an id, or none")


def xdmf(path):
    """Breaches of an XDMF index: what it names must be there, with the shape that it tells."""
    breaches = []
    for item in ElementTree.parse(path).iter("DataItem"):
        name, _, inside = item.text.partition(":")
        shape = tuple(map(int, item.get("Dimensions").split()))
        with h5py.File(Path(path).parent / name) as file:
            if inside not in file or file[inside].shape != shape:
                breaches.append(f"{path}: {item.text} has not the shape {shape}")
    return breaches


def main(paths):
    breaches = []
    for path in paths:
        if path.endswith(".xdmf"):
            breaches += xdmf(path)
            continue
        checker = Checker(path)
        breaches += checker.breaches
        if hasattr(checker, "rows"):
            print(
                f"{path}: {checker.elements} elements, {checker.frames} frames, {checker.rows} "
                f"particles")
    print("\n".join(breaches))
    return 1 if breaches or not paths else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
