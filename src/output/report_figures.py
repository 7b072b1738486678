# The pictures of a report: the body before and after, speeds, gravity, where the time went.
# SPDX-License-Identifier: BSD-3-Clause
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import LinearSegmentedColormap, LogNorm
from matplotlib.ticker import NullFormatter

from report_run import readable_length
from report_spheres import Camera, render

SKY = np.array([0.035, 0.043, 0.066])
INK, BLUE, ORANGE = "#1c2430", "#2f6db3", "#d9822b"
GREEN, RED, GREY = "#3f8f5b", "#b5413a", "#8a94a3"
plt.rcParams.update({
    "font.family": "DejaVu Sans", "font.size": 10, "axes.edgecolor": GREY, "axes.labelcolor": INK,
    "axes.spines.top": False, "axes.spines.right": False, "axes.titlesize": 11,
    "axes.titleweight": "bold", "axes.titlelocation": "left", "xtick.color": INK,
    "ytick.color": INK, "axes.grid": True, "grid.color": "#e4e8ee", "grid.linewidth": 0.7,
    "axes.axisbelow": True, "legend.frameon": False, "lines.linewidth": 1.4, "figure.dpi": 150,
})


# Of rock, and of the groups after the first: steel, copper, moss, brick, lilac, sea.
TINTS = np.array([[0.98, 0.93, 0.86], [0.55, 0.72, 0.95], [0.98, 0.66, 0.38], [0.58, 0.83, 0.56],
                  [0.93, 0.52, 0.48], [0.76, 0.65, 0.96], [0.45, 0.83, 0.82]])


def rock(group):
    """A tint a group, a little different for each body, always the same for the same body."""
    noise = np.random.default_rng(1).random((len(group), 2))
    shade = 0.70 + 0.24 * noise[:, :1]
    warmth = (noise[:, 1:] - 0.5) * 0.06
    return shade * TINTS[group % len(TINTS)] + warmth * np.array([1, 0, -1])


def nice_length(length):
    """The largest of 1, 2, 5 times a power of ten that is not above `length`."""
    power = 10 ** np.floor(np.log10(length))
    return max(f * power for f in (1, 2, 5) if f * power <= length)


def scale_bar(axes, camera):
    bar = nice_length(camera.width / 5)
    x, y = -camera.width / 2 * 0.93, -camera.height / 2 * 0.92
    axes.plot([x, x + bar], [y, y], color="white", lw=2, solid_capstyle="butt")
    axes.text(x + bar / 2, y + camera.height * 0.015, readable_length(bar), color="white",
              ha="center", va="bottom", fontsize=9)


def show(axes, camera, image):
    axes.imshow(image, extent=[-camera.width / 2, camera.width / 2, -camera.height / 2,
                               camera.height / 2], interpolation="lanczos")
    axes.set_xlim(-camera.width / 2, camera.width / 2)
    axes.set_ylim(-camera.height / 2, camera.height / 2)
    axes.axis("off")


def pile_size(frame, share=0.98):
    """Middle and a size (m) that holds this share of the bodies: those far away do not count."""
    middle = np.median(frame.position, axis=0)
    distance = np.linalg.norm(frame.position - middle, axis=1) + frame.radius
    return middle, 2 * np.quantile(distance, share)


def before_and_after(run):
    """The bodies before the impact and at the end, seen from where the impactor came."""
    _, size = pile_size(run.before)
    # A cloud of debris, and what spreads further, would leave too little to see of the rest.
    size = min(max(size, pile_size(run.after, 0.9)[1]), 2 * size)
    side, up = run.side_view()
    toward = 0.85 * side - 0.62 * run.flight + 0.42 * up
    figure, axes = plt.subplots(1, 2, figsize=(12, 6.2), facecolor=tuple(SKY))
    for panel, frame in zip(axes, (run.before, run.after)):
        center = np.median(frame.position, axis=0)
        camera = Camera(toward, up, center, 1.42 * size, 1.42 * size, 760)
        color = rock(frame.group)
        of, places, radii = frame.spheres
        show(panel, camera, render(camera, places, radii, color[of], SKY))
        scale_bar(panel, camera)
        panel.set_title(run.name_of(frame), color="white", fontsize=12, pad=4, loc="center")
        if run.since_impact(frame) == 0:
            x, y, _ = camera.project(center - run.flight * size * np.array([[0.95], [0.62]]))
            panel.annotate("", (x[1], y[1]), (x[0], y[0]),
                           arrowprops={"arrowstyle": "-|>", "color": "#ffb454", "lw": 2})
            panel.text(-0.69 * size, min(y) - 0.03 * size, run.impactor_text, color="#ffb454",
                       va="top", fontsize=9)
    figure.subplots_adjust(0.005, 0.01, 0.995, 0.93, wspace=0.01)
    return figure


def velocities(run):
    """Cut through the bodies at the end, coloured by speed, with arrows; and how speeds spread."""
    frame = run.after.without(run.impactor)
    middle, size = pile_size(run.before)
    center = np.median(frame.position, axis=0)
    speed = np.linalg.norm(frame.velocity, axis=1)
    moving = speed[speed > 0]
    side, up = run.side_view()
    figure = plt.figure(figsize=(12, 6.2))
    grid = figure.add_gridspec(2, 2, width_ratios=[1.25, 1], hspace=0.38, wspace=0.22, left=0.01,
                               right=0.985, top=0.93, bottom=0.09)
    if len(moving) == 0:
        figure.text(0.5, 0.5, "nothing moves", ha="center")
        return figure
    low, high = np.quantile(moving, [0.02, 0.9995])
    spread = np.sqrt(max(10 * low / high, 1))  # to a decade: what moves alike is coloured alike
    norm = LogNorm(low / spread, high * spread, clip=True)
    colors = LinearSegmentedColormap.from_list(
        "speeds", plt.get_cmap("inferno")(np.linspace(0.22, 1, 256)))

    panel = figure.add_subplot(grid[:, 0])
    camera = Camera(side, up, center, 1.75 * size, 1.55 * size, 900)
    across = (frame.position - center) @ camera.toward
    behind = across <= 0
    rgb = colors(norm(np.maximum(speed, low)))[:, :3]
    of, places, radii = frame.spheres
    drawn = behind[of]
    image = render(camera, places[drawn], radii[drawn], rgb[of[drawn]], SKY, soft=True)
    show(panel, camera, image)
    scale_bar(panel, camera)
    near = np.flatnonzero(behind & (across > -1.2 * frame.radius))
    near = near[np.argsort(-speed[near])][:400]
    x, y, _ = camera.project(frame.position[near])
    length = 0.16 * size * np.sqrt(speed[near] / norm.vmax)
    # What rests has no direction.
    direction = frame.velocity[near] / np.maximum(speed[near], np.finfo(float).tiny)[:, None]
    u, v = direction @ camera.right * length, direction @ camera.up * length
    panel.quiver(x, y, u, v, angles="xy", scale_units="xy", scale=1, width=0.0026,
                 color="#7fd4ff", clip_on=True)
    if run.has_impact:
        panel.annotate("", (-0.56 * size, 0), (-0.78 * size, 0),
                       arrowprops={"arrowstyle": "-|>", "color": "#ffb454", "lw": 2})
    panel.set_title(f"Cut along the flight of the impactor, {run.name_of(run.after)}"
                    if run.has_impact else f"Cut through the middle, {run.name_of(run.after)}")
    bar = figure.colorbar(plt.cm.ScalarMappable(norm, colors), ax=panel, fraction=0.03, pad=0.02,
                          shrink=0.75)
    bar.set_label("speed (m/s)")
    bar.ax.yaxis.set_minor_formatter(NullFormatter())
    bar.outline.set_visible(False)

    panel = figure.add_subplot(grid[0, 1])
    bins = np.geomspace(min(moving.min(), norm.vmin) * 0.99, max(moving.max(), norm.vmax) * 1.01,
                        60)
    _, _, patches = panel.hist(moving, bins)
    for patch, edge in zip(patches, bins):
        patch.set_facecolor(colors(float(norm(edge))))
    panel.set(xscale="log", yscale="log", xlabel="speed (m/s)", ylabel="bodies")
    panel.set_title("Speeds", pad=16)  # above the names of marks
    for value, name, color in run.marked_speeds():
        panel.axvline(value, color=color, lw=1.2, ls="--")
        panel.text(value, 1.01, name, color=color, fontsize=8, ha="center", va="bottom",
                   transform=panel.get_xaxis_transform())

    panel = figure.add_subplot(grid[1, 1])
    along = (frame.position - center) @ run.flight
    order = np.argsort(speed)
    forward = frame.velocity @ run.flight
    panel.scatter(along[order], forward[order], s=7, c=rgb[order], linewidths=0)
    reach = 1.1 * size
    panel.set_xlim(-reach, reach)
    if forward.any():
        median = np.median(np.abs(forward[forward != 0]))
        panel.set_yscale("symlog", linthresh=10 ** np.floor(np.log10(median)))
    panel.set(xlabel=f"place along {'the flight' if run.has_impact else 'x'} (m)",
              ylabel="velocity along it (m/s)",
              title="Velocity along the flight of the impactor" if run.has_impact
              else "Velocity along x")
    return figure


def gravity(run):
    """Potential and pull in the middle plane of the map, across its shortest side."""
    grid, names = run.gravity, "xyz"
    across = int(np.argmin(grid.counts))
    right, up = (k for k in range(3) if k != across)
    middle = grid.counts[across] // 2
    level = grid.low[across] + grid.spacing * middle
    x, y = (grid.low[k] + grid.spacing * np.arange(grid.counts[k]) for k in (right, up))
    potential, pull = (np.swapaxes(np.take(values, middle, axis=across), 0, 1)  # rows go up
                       for values in (grid.potential, grid.acceleration))
    size = np.linalg.norm(pull, axis=-1)
    apart = run.after.position[:, across] - level
    cut = np.sqrt(np.maximum(run.after.radius**2 - apart**2, 0))
    figure, axes = plt.subplots(1, 2, figsize=(12, 5.4), layout="constrained")
    for panel, values, name in ((axes[0], potential * 1e3, "potential (mJ/kg)"),
                                (axes[1], size * 1e6, "pull (µm/s²)")):
        image = panel.contourf(x, y, values, 24, cmap="viridis")
        panel.contour(x, y, values, 12, colors="white", linewidths=0.5, alpha=0.6)
        figure.colorbar(image, ax=panel, label=name, shrink=0.85).outline.set_visible(False)
        panel.set(aspect="equal", xlabel=f"{names[right]} (m)", ylabel=f"{names[up]} (m)")
        panel.grid(False)
        for b in np.flatnonzero(cut):
            panel.add_patch(plt.Circle(run.after.position[b, [right, up]], cut[b], fill=False,
                                       lw=0.4, color="white", alpha=0.7))
        panel.set(xlim=x[[0, -1]], ylim=y[[0, -1]])
    every = slice(None, None, max(1, max(len(x), len(y)) // 24))
    arrows = (pull / np.maximum(size, 1e-300)[..., None])[every, every]
    axes[1].quiver(x[every], y[every], arrows[..., right], arrows[..., up], color="white", scale=36,
                   width=0.0025)
    axes[0].set_title(f"Plane {names[across]} = {level:.3g} m, {run.name_of(run.after)}")
    return figure


def stage_times(seconds):
    """Share of each stage of the steps."""
    total = sum(seconds.values())
    palette = [BLUE, ORANGE, GREEN, RED, "#7a5ea8", "#4aa3a2", GREY, "#c9a227", "#5b6472"]
    figure, axes = plt.subplots(figsize=(12, 1.5), layout="constrained")
    left = 0
    for (name, value), color in zip(sorted(seconds.items(), key=lambda item: -item[1]), palette):
        axes.barh(0, value / total, left=left, color=color, edgecolor="white",
                  label=f"{name}  {value:.3g} s ({100 * value / total:.0f} %)")
        left += value / total
    axes.set_xlim(0, 1)
    axes.axis("off")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, 0.08), ncols=4, fontsize=9)
    return figure


def read_outs(table, lines):
    """dv at the times of the read-out, beside what momentum alone gives."""
    figure, axes = plt.subplots(figsize=(12, 3.4), layout="constrained")
    time, dv = np.array(table["since_impact"]), np.array(table["dv"])
    axes.plot(time, dv * 1e3, "o-", color=BLUE)
    for t, v in zip(time, dv):
        axes.annotate(f"{v * 1e3:.4g}", (t, v * 1e3), textcoords="offset points", xytext=(6, 6),
                      fontsize=9, color=BLUE)
    for value, name in lines:
        axes.axhline(value * 1e3, color=GREY, ls="--", lw=1)
        # At the left: values stand right of their points.
        axes.text(0.005, value * 1e3, name, color="#5b6472", fontsize=8, ha="left", va="bottom",
                  transform=axes.get_yaxis_transform())
    top = max([*dv, *(value for value, _ in lines)]) * 1e3
    axes.set(xlabel="time since the impact (s)", ylabel="dv of the largest clump (mm/s)",
             xlim=(0, time[-1] * 1.12), ylim=(min(0, dv.min() * 1e3), top * 1.2))
    return figure


def ejecta_speeds(ejecta):
    """Mass and number of bodies that are faster than a speed."""
    figure, panels = plt.subplots(1, 2, figsize=(12, 3.4), layout="constrained")
    for axes, key, name in ((panels[0], "mass_faster", "mass faster than v (kg)"),
                            (panels[1], "count_faster", "bodies faster than v")):
        axes.loglog(ejecta["speeds"], ejecta[key], "o-", color=BLUE)
        axes.set(xlabel="speed v (m/s)", ylabel=name)
        axes.grid(color="#e4e8ee")
    return figure
