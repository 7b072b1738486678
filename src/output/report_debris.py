# Pictures of a plate's impact: a film strip of radiographs, speeds, and what a wall would receive.
# SPDX-License-Identifier: BSD-3-Clause
import os

import h5py
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import LogNorm

import report_film as film
from report_figures import BLUE, GREY, INK, ORANGE, RED
from report_run import readable_time


def plates(run):
    """(name, what its sections of the results end in) of each plate that [debris] names."""
    debris = run.case["debris"]
    names = [debris["plate"]] if "plate" in debris else debris["plates"]
    ends = [section.removeprefix("cloud") for section in run.results
            if section == "cloud" or section.startswith("cloud_")]
    return list(zip(names, ends))  # results are in the order of the case


class Flight:
    """Bodies of projectile and plate in the plate's frame: depth behind its rear face, and
    across."""

    def __init__(self, run, plate, end):
        groups = [group["name"] for group in run.case["groups"]]
        self.ball = groups.index(run.case["debris"]["projectile"])
        self.plate = groups.index(plate)
        with h5py.File(os.path.join(run.folder, "trajectory.h5")) as file:
            all_bodies = file["particles/all"]
            self.time = all_bodies["position/time"][:]
            group = all_bodies["group"][:]
            own = np.isin(group, (self.ball, self.plate))
            self.group, self.mass = group[own], all_bodies["mass"][:][own]
            self.position = all_bodies["position/value"][:][:, own]
            self.velocity = all_bodies["velocity/value"][:][:, own]
            self.yields = "plastic_strain" in all_bodies
            self.damage, self.temperature = (
                all_bodies[name + "/value"][-1][own] if name in all_bodies else None
                for name in ("damage", "temperature"))
        table = run.results["debris" + end]
        self.cloud = {key: np.array(value) for key, value in run.results["cloud" + end].items()}
        self.wall = run.results.get("wall" + end)
        self.diameter, self.speed = table["diameter"], table["speed"]
        self.origin, self.normal = np.array(table["origin"]), np.array(table["normal"])
        side = np.eye(3)[(np.argmax(np.abs(self.normal)) + 1) % 3]
        side -= (side @ self.normal) * self.normal
        self.side = side / np.linalg.norm(side)

    def depth(self, k):
        return (self.position[k] - self.origin) @ self.normal

    def axial(self, k):
        return self.velocity[k] @ self.normal

    def height(self, k):
        return (self.position[k] - self.origin) @ self.side


def radiographs(flight):
    """Of projectile and plate, until the end."""
    frames = film.frames_of(flight.time)
    last = frames[-1]
    debris = flight.depth(last) > flight.diameter / 4
    reach = np.quantile(flight.depth(last)[debris], 0.999) if debris.any() else flight.diameter
    wide = np.abs(flight.height(0)).max()
    if debris.any():
        # One in a hundred flies far off to the side.
        wide = max(wide, 1.1 * np.quantile(np.abs(flight.height(last)[debris]), 0.99))
    low, high = -2.2 * flight.diameter, 1.05 * reach
    wide = min(wide, film.HIGHEST / 2 * (high - low))
    extent = (low, high, -wide, wide)
    pixel = 0.7 * flight.diameter / 12
    maps = [film.column_map(flight.depth(k), flight.height(k), flight.mass, extent, pixel)
            for k in frames]
    ball = flight.group == flight.ball
    black = film.black_of(flight.mass[ball].sum(), flight.diameter)
    return film.strip(flight.time[frames], maps, extent, black, "mm behind the plate")


def speeds(flight):
    """Where the debris are and how fast, by origin, and the cloud against time."""
    k = len(flight.time) - 1
    speed = flight.speed
    debris = flight.depth(k) > flight.diameter / 4
    figure, axes = plt.subplots(1, 3, figsize=(12, 3.9), layout="constrained")
    panel = axes[0]
    order = np.argsort(-flight.axial(k)[debris])
    x, y = flight.depth(k)[debris][order], flight.height(k)[debris][order]
    dots = panel.scatter(1e3 * x, 1e3 * y, s=2, linewidths=0, cmap="inferno", vmin=0,
                         vmax=speed, c=flight.axial(k)[debris][order])
    panel.set(xlabel="mm behind the plate", ylabel="mm", aspect="equal",
              title=f"speed along the normal, {readable_time(flight.time[k])}")
    figure.colorbar(dots, ax=panel, label="m/s", shrink=0.8)
    panel = axes[1]
    bins = np.linspace(0, 1.1, 45)
    for group, color, name in ((flight.ball, ORANGE, "projectile"), (flight.plate, BLUE, "plate")):
        chosen = debris & (flight.group == group)
        panel.hist(flight.axial(k)[chosen] / speed, bins, weights=1e3 * flight.mass[chosen],
                   color=color, alpha=0.75, label=name)
    panel.set(xlabel="speed along the normal / speed of the impact", ylabel="g", yscale="log",
              title="debris by origin")
    panel.legend()
    panel = axes[2]
    cloud = flight.cloud
    for key, color in (("front", RED), ("radial", ORANGE), ("centre", BLUE), ("rear", GREY)):
        panel.plot(1e6 * cloud["time"], cloud[key] / speed, "o-", ms=3, color=color, label=key)
    panel.plot(1e6 * cloud["time"], cloud["hole"] / flight.diameter, "s--", ms=3, color=INK,
               label="hole / D")
    panel.set(xlabel="µs", title="over the speed of the impact", ylim=(0, None))
    panel.legend(fontsize=8, ncols=2)
    return figure


def state(flight):
    """A slice through the axis at the end: damage, which of bonds is the share that is broken, and
    temperature. None where none can break."""
    if flight.damage is None or not flight.damage.any():
        return None
    k = len(flight.time) - 1
    across = (flight.position[k] - flight.origin) @ np.cross(flight.normal, flight.side)
    chosen = np.abs(across) < flight.diameter / 12
    x, y = 1e3 * flight.depth(k)[chosen], 1e3 * flight.height(k)[chosen]
    damage = "damage" if flight.yields else "share of bonds broken"
    fields = [(flight.damage, damage, "inferno", 1)]
    if flight.temperature is not None:
        top = np.nanquantile(flight.temperature[chosen], 0.99)
        fields.append((flight.temperature, "temperature, K", "inferno", top))
    figure, axes = plt.subplots(1, len(fields), figsize=(6 * len(fields), 4.2), squeeze=False,
                                layout="constrained")
    for panel, (values, name, colors, top) in zip(axes.flat, fields):
        order = np.argsort(values[chosen])
        dots = panel.scatter(x[order], y[order], c=values[chosen][order], s=3, linewidths=0,
                             cmap=colors, vmax=top)
        panel.set(xlabel="mm behind the plate", ylabel="mm", aspect="equal",
                  title=readable_time(flight.time[k]))
        figure.colorbar(dots, ax=panel, shrink=0.8, label=name)
    return figure


def wall(flight):
    """Momentum that debris flying on freely bring to each place of a wall. None without debris."""
    distance = flight.wall["distance"]
    k = len(flight.time) - 1
    axial, depth = flight.axial(k), flight.depth(k)
    chosen = (depth > flight.diameter / 4) & (axial > 0)
    if not chosen.any():
        return None
    left = (distance - depth[chosen]) / axial[chosen]  # also of what has gone farther
    place = flight.position[k][chosen] - flight.origin + left[:, None] * flight.velocity[k][chosen]
    hit = [place @ flight.side, place @ np.cross(flight.normal, flight.side)]
    half = 1.2 * flight.wall["radius"]
    pixel = flight.diameter / 2
    bins = np.arange(-np.ceil(half / pixel) * pixel, half + pixel, pixel)
    map_, _, _ = np.histogram2d(*hit, bins=[bins, bins],
                                weights=flight.mass[chosen] * axial[chosen] / pixel**2)
    figure, axes = plt.subplots(figsize=(5.6, 4.6), layout="constrained")
    positive = map_[map_ > 0]
    image = axes.imshow(np.where(map_ > 0, map_, np.nan).T, origin="lower", cmap="inferno",
                        norm=LogNorm(positive.min(), positive.max()),
                        extent=[1e3 * bins[0], 1e3 * bins[-1]] * 2)
    turn = np.linspace(0, 2 * np.pi, 100)
    for key, style in (("half_radius", "-"), ("radius", "--")):
        r = 1e3 * flight.wall[key]
        axes.plot(r * np.cos(turn), r * np.sin(turn), style, color=GREY, lw=1)
    axes.set(xlabel="mm", ylabel="mm", title=f"momentum on a wall {1e3 * distance:g} mm behind")
    axes.grid(False)
    figure.colorbar(image, label="Pa s")
    return figure
