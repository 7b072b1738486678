# What is inside a pile: density, voids, contacts and the forces that they carry, from restart
# files.
# SPDX-License-Identifier: BSD-3-Clause
import os

import h5py
import numpy as np

from report_figures import BLUE, GREEN, GREY, ORANGE, RED, plt

MOVE_ON = "bodies move on"  # in place of forces


class Inside:
    """The bodies of a restart file that hang together, about their centre of mass, and their
    contacts.

    Impulses are turned into forces by the virial of a body at rest, sum f.d = -sum m a.x: a held
    field of gravity acts as one kick, so that the impulses of a step belong to a longer time than
    the step. Forces are no numbers where bodies move on: there pulls are as many as pushes, and
    their sum tells nothing."""

    def __init__(self, path, reach):
        with h5py.File(path) as file:
            order = np.argsort(file["bodies/id"][:])
            bodies = file["bodies"]
            self.position, self.radius, self.mass = (bodies[key][:][order]
                                                     for key in ("position", "radius", "mass"))
            # Smooth methods without gravity have no such field.
            self.acceleration = bodies["acceleration"][:][
                order] if "acceleration" in bodies else np.zeros_like(self.position)
            i, j, impulse = (file[f"contacts/{key}"][:] for key in ("i", "j", "impulse"))
        # What is fixed belongs to no pile.
        self.mass = np.where(np.isfinite(self.mass), self.mass, 0)
        # Contacts between bodies of two ranks stand there by both.
        _, once = np.unique(np.stack([i, j]), axis=1, return_index=True)
        pair = once[(j[once] >= 0) & (i[once] < len(order)) & (j[once] < len(order))]
        i, j, impulse = i[pair], j[pair], impulse[pair]
        between = self.position[j] - self.position[i]
        distance = np.linalg.norm(between, axis=1)
        near = distance - self.radius[i] - self.radius[j] <= reach
        self.i, self.j = i[near], j[near]
        normal_impulse = np.sum(impulse * between, axis=1)[near] / distance[near]
        clump = self.largest_clump()
        self.position -= np.average(self.position[clump], axis=0, weights=self.mass[clump])
        self.clump = clump
        inner = clump[self.i] & clump[self.j]
        self.i, self.j, normal_impulse = self.i[inner], self.j[inner], normal_impulse[inner]
        virial = -np.sum(self.mass[clump, None] * self.acceleration[clump] * self.position[clump])
        products = normal_impulse * np.linalg.norm(self.position[self.j] - self.position[self.i],
                                                   axis=1)
        self.rests = virial > 0 and products.sum() > 0.5 * np.abs(products).sum()
        self.force = normal_impulse * (virial / products.sum() if self.rests else np.nan)
        self.coordination = (np.bincount(self.i, minlength=len(self.mass))
                             + np.bincount(self.j, minlength=len(self.mass)))[clump]

    def largest_clump(self):
        name = np.arange(len(self.mass))
        while True:
            low = np.minimum(name[self.i], name[self.j])
            before = name.copy()
            np.minimum.at(name, self.i, low)
            np.minimum.at(name, self.j, low)
            name = name[name]
            if np.array_equal(name, before):
                return name == np.argmax(np.bincount(name, self.mass))

    def size(self):
        return np.max(np.linalg.norm(self.position[self.clump], axis=1) + self.radius[self.clump])

    def second_moments(self):
        """kg m^2, of mass about the centre, spheres' own included."""
        x, m, r = self.position[self.clump], self.mass[self.clump], self.radius[self.clump]
        return (m[:, None] * x).T @ x + 0.2 * np.sum(m * r**2) * np.eye(3)

    def moments(self):
        """kg m^2, principal moments of inertia, smallest first."""
        second = self.second_moments()
        return np.linalg.eigvalsh(np.eye(3) * np.trace(second) - second)

    def room(self, axis, share):
        """m, at the points of a cubic grid: a ball of this radius is wholly within `share` of the
        ellipsoid with the same moments; negative outside of that."""
        mass = self.mass[self.clump].sum()
        squares, axes = np.linalg.eigh(5 * self.second_moments() / mass)
        scaled = np.linalg.norm(points_of(axis) @ axes / np.sqrt(squares), axis=1)
        # It grows by no more than 1 over the shortest half axis a metre.
        return ((share - scaled) * np.sqrt(squares[0])).reshape((len(axis),) * 3)

    def profile(self, edges):
        """Solid part of the shells between `edges` (m), by the lens that a ball and a sphere
        share."""
        d = np.linalg.norm(self.position[self.clump], axis=1)
        r = self.radius[self.clump]
        inside = np.array([np.sum(shared_volume(R, r, d)) for R in edges])
        return np.diff(inside) / (4 / 3 * np.pi * np.diff(edges**3))

    def distance_to_solid(self, points_a_side):
        """On a cubic grid about the centre: distance (m) from each point to the nearest sphere's
        surface, negative inside; and the places along an axis. Farther than four mean radii is not
        looked."""
        side = self.size()
        axis = np.linspace(-side, side, points_a_side)
        step = axis[1] - axis[0]
        distance = np.full((points_a_side,) * 3, np.inf)
        look = 4 * np.median(self.radius[self.clump])
        for x, r in zip(self.position[self.clump], self.radius[self.clump]):
            low = np.maximum(np.ceil((x - r - look + side) / step).astype(int), 0)
            high = np.minimum(np.floor((x + r + look + side) / step).astype(int) + 1, points_a_side)
            gx, gy, gz = (axis[a:b] - c for a, b, c in zip(low, high, x))
            here = np.sqrt(gx[:, None, None]**2 + gy[None, :, None]**2 + gz[None, None, :]**2) - r
            window = distance[low[0]:high[0], low[1]:high[1], low[2]:high[2]]
            np.minimum(window, here, out=window)
        return axis, distance


def shared_volume(R, r, d):
    """m^3, of a ball of radius R about the origin and balls of radii r at distances d
    (src/analysis/interior.cpp)."""
    small, large = np.minimum(R, r), np.maximum(R, r)
    d = np.maximum(d, 1e-300)
    cap = np.clip((small - large + d) * (small + large - d) / (2 * d), 0, None)
    other = small + large - d - cap
    lens = np.pi / 3 * (cap**2 * (3 * large - cap) + other**2 * (3 * small - other))
    return np.where(d >= small + large, 0,
                    np.where(d <= large - small, 4 / 3 * np.pi * small**3, lens))


def points_of(axis):
    return np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)


def largest_voids(axis, distance, room, count):
    """Radii (m) of the largest balls that fit between the spheres, apart from each other; none is
    larger than its middle has `room` (m) for."""
    grid = points_of(axis)
    radius = np.where(distance <= room, distance, -1).ravel()
    found = []
    for _ in range(count):
        k = int(np.argmax(radius))
        if not radius[k] > 0:
            break
        found.append(radius[k])
        radius[np.linalg.norm(grid - grid[k], axis=1) < 2 * radius[k]] = -1
    return np.array(found)


def restart_files(run):
    """Name and path of the states before the impact and at the end, as far as they are there and
    hold impulses."""
    phases = run.case.get("phases", [])
    impact = next((k for k, phase in enumerate(phases) if "impactor" in phase), None)
    wanted = [("at the end", len(phases) - 1)]
    if impact is not None:
        wanted = [("before the impact", impact - 1), ("after it", len(phases) - 1)]
    paths = [(name, os.path.join(run.folder, f"after_{phases[k]['name']}.h5")) for name, k in wanted
             if k >= 0 and phases[k].get("method", "nonsmooth") == "nonsmooth"]
    return [(name, path) for name, path in paths if os.path.exists(path)]


def has_clumps(path):
    """Whether bodies of a restart file are unions of spheres, whose radius is that around them."""
    with h5py.File(path) as file:
        return "bodies/shape" in file and bool(np.any(file["bodies/shape"][:]))


def interior(run):
    """Figure and table rows of the inside, before and after; None without restart files, where
    bodies are not held together by their own gravity alone, which the virial asks for, and of
    clumps: balls around them would fill more than all of the pile."""
    gravity = run.case.get("gravity", {})
    if gravity.get("method", "none") == "none" or "uniform" in gravity:
        return None
    reach = 1e-3 * np.median(run.before.radius)
    files = restart_files(run)
    if any(has_clumps(path) for _, path in files):
        return None
    states = [(name, Inside(path, reach)) for name, path in files]
    # A pile by its own gravity.
    if not any(state.rests for _, state in states):
        return None
    figure, axes = plt.subplots(len(states) + 1, 3, figsize=(12, 4.1 * (len(states) + 1)),
                                layout="constrained", squeeze=False)
    edges = np.linspace(0, states[0][1].size(), 25)
    rows, side = [], states[0][1].size()
    across, up = run.side_view()
    for (name, state), line, color in zip(states, axes, (BLUE, ORANGE)):
        axis, distance = state.distance_to_solid(81)
        voids = largest_voids(axis, distance, state.room(axis, 0.85), 10)
        rows.append((name, state, voids))
        top = axes[-1]
        top[0].stairs(1 - state.profile(edges), edges, color=color, label=name)
        top[1].hist(state.coordination, np.arange(-0.5, state.coordination.max() + 1.5),
                    histtype="step", color=color, label=name)
        pushing = state.force[state.force > 0]
        if state.rests:
            bins = np.geomspace(max(pushing.mean() * 1e-3, 1e-300), pushing.max() * 1.01, 40)
            top[2].hist(pushing, bins, histtype="step", color=color, label=f"{name}, pushing")
        if np.any(state.force < 0):
            top[2].hist(-state.force[state.force < 0], bins, histtype="step", color=color, ls=":",
                        label=f"{name}, pulling")
        draw_map(figure, line[0], state, axis, distance, side, name)
        draw_network(line[1], state, state.force > 0, run.flight, up, across, side, GREEN,
                     f"Pushing contacts, {name}")
        draw_network(line[2], state, state.force < 0, run.flight, up, across, side, RED,
                     f"Pulling contacts, {name}")
    axes[-1][0].set(xlabel="distance from the centre (m)", ylabel="porosity of the shell",
                    ylim=(0, 1), title="Porosity, what is outside counted as empty")
    axes[-1][1].set(xlabel="contacts of a body", ylabel="bodies", title="Coordination")
    axes[-1][2].set(xscale="log", yscale="log", xlabel="normal force (N)", ylabel="contacts",
                    title="Forces")
    for panel in axes[-1]:
        low, high = panel.get_ylim()  # and room above for what the lines are
        room = (high / low) ** 0.3 if panel.get_yscale() == "log" else 1.3
        panel.set_ylim(low, room * high)
        panel.legend(fontsize=8)
    return figure, rows


def draw_map(figure, panel, state, axis, distance, side, name):
    """Porosity in the plane z = 0 about the centre: the empty part of a cube of grid points around
    each place."""
    empty = (distance > 0).astype(float)
    width = max(1, int(round(2 * np.median(state.radius) / (axis[1] - axis[0]))))
    for k in range(3):
        sums = np.cumsum(np.pad(empty, [(width + 1, width) if a == k else (0, 0) for a in range(3)],
                                "edge"), axis=k)
        n = empty.shape[k]
        ends = np.arange(2 * width + 1, 2 * width + 1 + n)
        empty = (np.take(sums, ends, k) - np.take(sums, ends - 2 * width - 1, k)) / (2 * width + 1)
    middle = len(axis) // 2
    image = panel.imshow(empty[:, :, middle].T, origin="lower", extent=[-side, side, -side, side],
                         vmin=0.2, vmax=0.8, cmap="viridis")
    panel.set(title=f"Porosity in the plane z = 0, {name}", xlabel="x (m)", ylabel="y (m)")
    panel.grid(False)
    figure.colorbar(image, ax=panel, shrink=0.8)


def draw_network(panel, state, chosen, flight, up, across, side, color, title):
    """Lines between the centres of bodies near the plane through the flight, as wide as the root of
    the force."""
    depth = np.abs(state.position @ across)
    near = chosen & (depth[state.i] < 2 * state.radius[state.i]) & (depth[state.j] < 2
                                                                    * state.radius[state.j])
    x, y = state.position @ flight, state.position @ up
    strength = np.abs(state.force)
    scale = np.quantile(strength[chosen], 0.99) if np.any(chosen) else 1
    for i, j, f in zip(state.i[near], state.j[near], strength[near]):
        panel.plot([x[i], x[j]], [y[i], y[j]], color=color,
                   lw=0.2 + 2.5 * np.sqrt(min(f / scale, 1)), solid_capstyle="round")
    if not np.any(near):
        panel.text(0, 0, "none" if state.rests else MOVE_ON, ha="center", color=GREY)
    panel.set(title=title, xlim=(-side, side), ylim=(-side, side), xlabel="along the flight (m)",
              aspect="equal")
    panel.grid(False)


def table(rows):
    """HTML of what the states are in figures."""
    def cell(values, form="{:.4g}"):
        return ", ".join(form.format(v) for v in np.atleast_1d(values))
    lines = [("", *(name for name, _, _ in rows))]
    lines.append(("bodies in the largest clump", *(str(int(s.clump.sum())) for _, s, _ in rows)))
    lines.append(("mean contacts of a body", *(cell(s.coordination.mean()) for _, s, _ in rows)))
    lines.append(("bodies with fewer than four",
                  *(f"{np.mean(s.coordination < 4):.1%}" for _, s, _ in rows)))
    lines.append(("contacts that pull", *(f"{np.mean(s.force < 0):.1%}" if s.rests else MOVE_ON
                                          for _, s, _ in rows)))
    lines.append(("largest force, N", *(cell(s.force.max()) if s.rests else MOVE_ON
                                        for _, s, _ in rows)))
    lines.append(("principal moments of inertia, kg m^2", *(cell(s.moments()) for _, s, _ in rows)))
    lines.append(("radii of the largest voids, m", *(cell(v[:5], "{:.2f}") for _, _, v in rows)))
    return lines
