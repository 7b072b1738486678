# Boulders gather, and a picture of them, in five lines.
# SPDX-License-Identifier: BSD-3-Clause
import spall
sim = spall.Simulation("cases/hello/case.toml", set={"groups.cloud.packing.count": 200})
sim.run_until(3600)
print(sim.energies(), sim.bodies.position.mean(axis=0))
sim.draw("pile.png")
