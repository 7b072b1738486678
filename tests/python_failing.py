# A force that fails on one rank alone; SPDX-License-Identifier: BSD-3-Clause
import spall

sim = spall.Simulation(materials={"rock": {"density": 1000}},
                       phases=[{"name": "only", "step": 0.01, "duration": 1}])
for k in range(4):
    sim.add("rock", radius=0.1, position=(k, 0, 0))


def force(bodies, forces):
    if spall.rank() == 1:
        raise ValueError("of one rank alone")


sim.add_force(force)
sim.run_until(0.2)
