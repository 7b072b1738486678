# A pile under its own gravity, pushed by a program's force, without files. Run by the tests.
# SPDX-License-Identifier: BSD-3-Clause
import numpy as np
import spall

sim = spall.Simulation(
    materials={"rock": {"density": "1600 kg/m^3"}},
    contact={"friction": 0.5, "restitution": 0.3},
    gravity={"method": "direct"},
    groups=[{"name": "cloud", "material": "rock", "volume": {"shape": "sphere", "radius": "9 m"},
             "packing": {"kind": "random", "radius": "1 m", "count": 200}}],
    phases=[{"name": "gather", "step": "5 s", "duration": "2 h"}])

gyration = []


def measure(sim):
    gyration.append(np.sqrt((sim.bodies.position**2).sum(axis=1).mean()))


sim.run_until(3600, each=measure, steps=60)


def push(bodies, forces):
    forces[:, 0] += 1e-6 * bodies.mass


sim.add_force(push)
sim.run_until(7200)
print(f"gyration radius {gyration[0]:.2f} m, later {gyration[-1]:.2f} m")
print(f"velocity {sim.bodies.velocity[:, 0].mean():.2e} m/s, {len(sim.pairs())} contacts")
sim.draw("pile.png")
