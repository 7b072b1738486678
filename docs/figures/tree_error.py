# Errors of the tree's forces against the exact sum, for three accuracies asked for.
# SPDX-License-Identifier: BSD-3-Clause
import numpy as np
from matplotlib import pyplot

import spall


def field(gravity):
    """Accelerations of the same 4,000 bodies, by id."""
    sim = spall.Simulation(
        materials={"rock": {"density": 2000}},
        gravity=gravity,
        groups=[{"name": "cloud", "material": "rock",
                 "volume": {"shape": "sphere", "radius": "100 m"},
                 "packing": {"kind": "random", "radius": "3 m", "count": 4000}}],
        phases=[{"name": "one", "step": "1 s", "duration": "1 s"}])
    sim.step()
    return sim.bodies.acceleration[np.argsort(sim.bodies.id)].copy()


exact = field({"method": "direct"})
mean = np.sqrt((exact**2).sum(axis=1).mean())

figure, axes = pyplot.subplots(figsize=(5.5, 3.6), layout="constrained")
bins = np.logspace(-8, -1.5, 60)
for k, accuracy in enumerate((1e-3, 1e-4, 1e-5)):
    error = np.linalg.norm(field({"method": "tree", "accuracy": accuracy}) - exact, axis=1) / mean
    axes.hist(error, bins, histtype="step", color=f"C{k}", label=f"accuracy {accuracy:.0e}")
    axes.axvline(accuracy, color=f"C{k}", linestyle="--", linewidth=0.8)
axes.set_xscale("log")
axes.set_xlabel("force error, over the mean force")
axes.set_ylabel("bodies")
axes.legend()
