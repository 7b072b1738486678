# A ball falls on a plane and bounces: heights and the time of rest against the formulas of
# restitution.
# SPDX-License-Identifier: BSD-3-Clause
import numpy as np
import spall

e, g, height = 0.8, 9.81, 1.0
sim = spall.Simulation(
    materials={"rubber": {"density": 1000}},
    contact={"restitution": e},
    gravity={"uniform": [0, 0, -g]},
    planes=[{"name": "floor"}],
    phases=[{"name": "fall", "step": "0.2 ms", "duration": "4.5 s"}])
sim.add("rubber", radius=0.05, position=(0, 0, 0.05 + height))

lowest = []  # height of the ball's lowest point, a row a step
sim.run_until(4.5, each=lambda sim: lowest.append(sim.bodies.position[0, 2] - 0.05))

z = np.array(lowest)
peaks = z[1:-1][(z[1:-1] > z[:-2]) & (z[1:-1] >= z[2:])]
for n, peak in enumerate(peaks[:5], start=1):
    expected = height * e ** (2 * n)
    print(f"bounce {n}: {peak:.4f} m, formula {expected:.4f} m")
    assert abs(peak / expected - 1) < 0.01

rest = np.sqrt(2 * height / g) * (1 + e) / (1 - e)
print(f"at rest after {rest:.2f} s by the formula; at the end at {z[-1]:.1e} m")
assert abs(z[-1]) < 1e-3
