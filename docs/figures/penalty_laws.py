# Normal forces of Hertz, DMT and JKR against the overlap, in units of JKR.
# SPDX-License-Identifier: BSD-3-Clause
import numpy as np
from matplotlib import pyplot

R = E = w = 1.0
pull_off = 1.5 * np.pi * w * R
a0 = (9 * np.pi * w * R**2 / (2 * E)) ** (1 / 3)  # contact radius of JKR without a load ...
rest = a0**2 / (3 * R)                            # ... and its overlap

overlap = np.linspace(0, 3 * rest, 300)
hertz = 4 / 3 * E * np.sqrt(R) * overlap**1.5
end = (np.pi * w * R**2 / (8 * E)) ** (1 / 3)     # where its neck ends
a = np.linspace(end, 2 * a0, 2000)
neck = a**2 / R - np.sqrt(2 * np.pi * w * a / E)
jkr = 4 * E * a**3 / (3 * R) - np.sqrt(8 * np.pi * w * E * a**3)
shown = neck < 3 * rest

figure, axes = pyplot.subplots(figsize=(5.5, 3.6), layout="constrained")
axes.plot(overlap / rest, hertz / pull_off, label="Hertz")
axes.plot(overlap / rest, (hertz - 2 * np.pi * w * R) / pull_off, label="DMT")
axes.plot(neck[shown] / rest, jkr[shown] / pull_off, label="JKR, parting")
axes.axhline(0, color="grey", linewidth=0.6)
axes.set_ylim(-1.6, 4)
axes.set_xlabel("overlap")
axes.set_ylabel("force, positive pushes apart")
axes.legend()
