# Boulders fall together by their own gravity until they rest: how long it takes, how dense the pile
# is.
# SPDX-License-Identifier: BSD-3-Clause
import numpy as np
import spall

G, density, radius, count = 6.67430e-11, 2000.0, 1.0, 150
sim = spall.Simulation(
    seed=1,
    materials={"rock": {"density": density}},
    contact={"friction": 0.5, "restitution": 0.3},
    gravity={"method": "direct"},
    groups=[{"name": "cloud", "material": "rock", "volume": {"shape": "sphere", "radius": "9 m"},
             "packing": {"kind": "random", "radius": radius, "count": count}}],
    phases=[{"name": "gather", "step": "10 s", "duration": "4 h",
             "until": "settled", "settled_speed": "0.05 mm/s"}])

cloud = count * density * radius**3 / 9**3                      # kg/m^3
free_fall = np.sqrt(3 * np.pi / (32 * G * cloud))
sim.run_until(4 * 3600)

place = sim.bodies.position - sim.bodies.position.mean(axis=0)
half = np.sort(np.linalg.norm(place, axis=1))[count // 2]       # half of the mass is inside
print(f"at rest after {sim.time:.0f} s; the free fall takes {free_fall:.0f} s")
print(f"half of the mass within {half:.2f} m, {len(sim.pairs())} contacts")
print(f"filled inside of it: {count / 2 * radius**3 / half**3:.2f}")
assert sim.over and sim.time > free_fall
sim.draw("pile.png")
