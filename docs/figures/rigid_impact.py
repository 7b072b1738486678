# Spheres hit a plane at many angles: what is left of the tangential speed, from runs and by
# formula.
# SPDX-License-Identifier: BSD-3-Clause
import numpy as np
from matplotlib import pyplot

import spall

mu, e = 0.2, 0.6
angles = np.radians(np.arange(5, 86, 5))  # from the normal
sim = spall.Simulation(
    materials={"rock": {"density": 2500}},
    contact={"friction": mu, "restitution": e},
    solver={"tolerance": 1e-8},
    planes=[{}],
    phases=[{"name": "hit", "step": "1 ms", "duration": "20 ms"}])
for k, angle in enumerate(angles):
    sim.add("rock", radius=0.01, position=(0.1 * k, 0, 0.0105),
            velocity=(np.sin(angle), 0, -np.cos(angle)))
sim.run_until(0.02)
after = sim.bodies.frame().velocity_x.to_numpy()
slip = np.radians(np.linspace(1, 89, 300))
slides = np.tan(slip) > 3.5 * mu * (1 + e)

figure, axes = pyplot.subplots(figsize=(5.5, 3.6), layout="constrained")
axes.plot(np.degrees(slip), np.where(slides, 1 - mu * (1 + e) / np.tan(slip), 5 / 7), "C0")
axes.plot(np.degrees(angles), after / np.sin(angles), "C1o")
axes.set_xlabel("angle from the normal, degrees")
axes.set_ylabel("tangential speed, after over before")
