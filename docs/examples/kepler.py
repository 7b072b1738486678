# Two bodies about each other: an orbit of eccentricity 0.5 against Kepler's third law.
# SPDX-License-Identifier: BSD-3-Clause
import numpy as np
import spall

G, mass, moon = 6.67430e-11, 1e12, 1e9                   # kg
apart, eccentricity = 1500.0, 0.5                        # m, at the widest
a = apart / (1 + eccentricity)
mu = G * (mass + moon)
speed = np.sqrt(mu * (2 / apart - 1 / a))                # vis-viva
period = 2 * np.pi * np.sqrt(a**3 / mu)

sim = spall.Simulation(
    materials={"rock": {"density": 2000}},
    gravity={"method": "direct", "refresh": 1e-5},       # evaluate the field at each step
    phases=[{"name": "orbit", "step": period / 2000, "duration": 1.2 * period}])
sim.add("rock", radius=50, mass=mass)
sim.add("rock", radius=5, mass=moon, position=(apart, 0, 0), velocity=(0, speed, 0))

times, distances = [], []


def measure(sim):
    times.append(sim.time)
    distances.append(np.linalg.norm(sim.bodies.position[1] - sim.bodies.position[0]))


sim.run_until(1.2 * period, each=measure)
near, far = np.argmin(distances), 1000 + np.argmax(distances[1000:])
print(f"nearest {distances[near]:.2f} m, Kepler {a * (1 - eccentricity):.2f} m")
print(f"period {times[far]:.0f} s, Kepler {period:.0f} s")
assert abs(distances[near] / (a * (1 - eccentricity)) - 1) < 1e-3
assert abs(times[far] / period - 1) < 2e-3
