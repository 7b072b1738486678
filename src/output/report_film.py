# Film strips of radiographs: dark where much mass is in the way of the light.
# SPDX-License-Identifier: BSD-3-Clause
import matplotlib.pyplot as plt
import numpy as np

from report_run import readable_time

FRAMES, COLUMNS = 6, 3
WIDTH = 12  # of a strip, inches
HIGHEST = 2  # depths: what is wider is cut off on the picture


def frames_of(times):
    """Snapshots next to equal times: a phase's last one and one that was due may fall together."""
    wanted = np.linspace(times[0], times[-1], FRAMES)
    return np.unique([np.abs(np.asarray(times) - t).argmin() for t in wanted])


def column_map(x, y, mass, extent, pixel):
    """kg/m^2 of bodies seen from the side. `extent`: least and largest x, and y (m)."""
    bins = [np.arange(low, high + pixel / 2, pixel) for low, high in (extent[:2], extent[2:])]
    weights = np.where(np.isfinite(mass), mass, 0)
    counts, _, _ = np.histogram2d(x, y, bins=bins, weights=weights / pixel**2)
    return counts.T


def black_of(mass, diameter):
    """kg/m^2, of which film is black: a ball's that it looks through the middle of."""
    return 1.5 * mass / (np.pi / 4 * diameter**2)


def strip(times, maps, extent, black, xlabel):
    """`maps`: the column map at each time (s). `extent` in m."""
    rows = -(-len(times) // COLUMNS)
    height = WIDTH / COLUMNS * (extent[3] - extent[2]) / (extent[1] - extent[0])
    figure, axes = plt.subplots(rows, COLUMNS, figsize=(WIDTH, rows * (height + 0.35)),
                                squeeze=False, layout="constrained")
    for panel, time, image in zip(axes.flat, times, maps):
        panel.imshow(1 - np.exp(-3 * image / black), origin="lower", cmap="gray_r", vmin=0, vmax=1,
                     extent=[1e3 * e for e in extent], interpolation="bilinear")
        panel.set_title(readable_time(time), loc="left")
        panel.grid(False)
        panel.tick_params(labelsize=8)
    for panel in axes.flat[len(times):]:
        panel.axis("off")
    axes.flat[0].set(xlabel=xlabel, ylabel="mm")
    return figure
