# A force of your own: grains fall through a liquid whose drag is Stokes's, to their final speed.
# SPDX-License-Identifier: BSD-3-Clause
import numpy as np
import spall

g, viscosity = 9.81, 1.0                                  # m/s^2, Pa s: glycerine
sim = spall.Simulation(
    materials={"glass": {"density": 2500}},
    gravity={"uniform": [0, 0, -g]},
    phases=[{"name": "sink", "step": "0.1 ms", "duration": "0.1 s"}])
radii = np.array([1, 2, 3]) * 1e-3
for k, radius in enumerate(radii):
    sim.add("glass", radius=radius, position=(0.02 * k, 0, 0))


def stokes(bodies, forces):
    forces -= 6 * np.pi * viscosity * bodies.radius[:, None] * bodies.velocity


sim.add_force(stokes)
sim.run_until(0.1)

rate = 4.5 * viscosity / (2500 * radii**2)                # 1/s, drag over mass and speed
for row, body in enumerate(sim.bodies.id):
    expected = g / rate[body] * (1 - np.exp(-rate[body] * sim.time))
    speed = -sim.bodies.velocity[row, 2]
    print(f"radius {radii[body] * 1e3:.0f} mm: {speed:.5f} m/s, formula {expected:.5f} m/s")
    assert abs(speed / expected - 1) < 0.03
print(f"the drag took {-sim.energies()['own_work']:.3g} J")
