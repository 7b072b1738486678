# A ball of rubber and one of clay on the same floor: restitution by pair of materials.
# SPDX-License-Identifier: BSD-3-Clause
import numpy as np
from matplotlib import pyplot

import spall

CASE = """
[materials.rubber]
density = "1100 kg/m^3"
[materials.clay]
density = "1800 kg/m^3"
[materials.floor]
density = "2500 kg/m^3"

[contact]
restitution = 0.9

[[contact.between]]
materials = ["clay", "floor"]
restitution = 0.3

[gravity]
uniform = [0, 0, "-9.81 m/s^2"]
[[planes]]
material = "floor"
[[phases]]
name = "fall"
step = "0.5 ms"
duration = "3 s"
"""

sim = spall.Simulation(spall.Scene(CASE))
for k, material in enumerate(("rubber", "clay")):
    sim.add(material, radius=0.05, position=(k, 0, 1.05))
times, heights = [], []


def measure(sim):
    times.append(sim.time)
    heights.append(sim.bodies.position[np.argsort(sim.bodies.id), 2] - 0.05)


sim.run_until(3, each=measure, steps=5)
figure, axes = pyplot.subplots(figsize=(5.5, 3.2), layout="constrained")
axes.plot(times, heights, label=["rubber", "clay"])
axes.set_xlabel("time, s")
axes.set_ylabel("height, m")
axes.legend()
