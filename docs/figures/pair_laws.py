# Energies of the pair laws against the distance, for one depth and one distance of rest.
# SPDX-License-Identifier: BSD-3-Clause
import numpy as np
from matplotlib import pyplot

r = np.linspace(0.85, 2, 400)


def mie(m, n):
    return (n * r**-m - m * r**-n) / (m - n)


a = 4 * 1.34 - 2  # steepness of aluminium's Hugoniot
laws = {"Lennard-Jones (Mie 12-6)": mie(12, 6),
        "Mie 10-5": mie(10, 5),
        "Morse, aluminium": np.exp(-2 * a * (r - 1)) - 2 * np.exp(-a * (r - 1)),
        "Steinhauser": np.where(r < 1, r**-12.0 - 2 * r**-6.0, 10 * (r - 1) ** 2 - 1)}

figure, axes = pyplot.subplots(figsize=(5.5, 3.6), layout="constrained")
for name, energy in laws.items():
    axes.plot(r, energy, label=name)
axes.axhline(0, color="grey", linewidth=0.6)
axes.set_ylim(-1.1, 1)
axes.set_xlabel("distance, of that at rest")
axes.set_ylabel("energy, of the depth")
axes.legend()
