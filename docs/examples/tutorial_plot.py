# The plot of the tutorial: two curves of one run, and the points of the sweep.
# SPDX-License-Identifier: BSD-3-Clause
import matplotlib
import pandas

matplotlib.use("Agg")
from matplotlib import pyplot

figure, (left, right) = pyplot.subplots(1, 2, figsize=(9, 3.5), layout="constrained")
for folder in ("pile", "smooth"):
    series = pandas.read_csv(f"out/{folder}/series.csv")
    gather = series[series.phase == 0]
    left.plot(gather.time, gather.gyration_radius, label=folder)
left.set_xlabel("time, s")
left.set_ylabel("gyration radius, m")
left.legend()

table = pandas.read_csv("out/pile-sweep/table.csv")
for seed, rows in table.groupby("seed"):
    cohesion, beta = rows["phases.impact.cohesion"], rows["deflection.beta_along"]
    right.plot(cohesion, beta, "o-", label=f"seed {seed}")
right.set_xlabel("cohesion")
right.set_ylabel("beta")
right.legend()
figure.savefig("tutorial.png", dpi=120)
