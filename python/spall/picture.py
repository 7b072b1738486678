"""A picture of spheres, the nearest drawn last."""
import numpy as np


def draw_spheres(bodies, file, along, colour, size):
    import matplotlib
    if file is not None:
        matplotlib.use("Agg")
    from matplotlib import pyplot
    from matplotlib.collections import EllipseCollection
    depth = "xyz".index(along)
    across, up = (k for k in range(3) if k != depth)
    place, radius = np.array(bodies.position), np.array(bodies.radius)
    if colour is None:
        colour, label = np.linalg.norm(bodies.velocity, axis=1), "speed, m/s"
    else:
        colour, label = np.asarray(colour), None
    # Who sees x to the right and z up looks along y; the other two are seen from where they end.
    order = np.argsort(-place[:, depth] if along == "y" else place[:, depth], kind="stable")
    figure, axes = pyplot.subplots(figsize=(size, size), layout="constrained")
    disks = EllipseCollection(2 * radius[order], 2 * radius[order], np.zeros(len(order)),
                              units="xy",
                              offsets=place[order][:, [across, up]], transOffset=axes.transData,
                              edgecolors="#00000040", linewidths=0.4, cmap="viridis")
    disks.set_array(colour[order])
    axes.add_collection(disks)
    if len(place) > 0:  # of several ranks one may own none
        low, high = (place - radius[:, None]).min(axis=0), (place + radius[:, None]).max(axis=0)
        axes.set_xlim(low[across], high[across])
        axes.set_ylim(low[up], high[up])
    axes.set_aspect("equal")
    axes.set_xlabel(f"{'xyz'[across]}, m")
    axes.set_ylabel(f"{'xyz'[up]}, m")
    figure.colorbar(disks, ax=axes, shrink=0.8, label=label)
    if file is not None:
        figure.savefig(file, dpi=120)
    return figure
