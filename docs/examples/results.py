# A run with files, and what it left.
# SPDX-License-Identifier: BSD-3-Clause
import matplotlib
import spall

matplotlib.use("Agg")

run = spall.run("cases/hello/case.toml", out="out/seed_2", set={"seed": 2})
print(run["deflection"]["beta_along"])   # results.toml
run.series.plot("time", "kinetic") # series.csv, a pandas frame
for time, bodies in run.frames():  # trajectory.h5
    cloud = bodies["group"] == 0   # the impactor's row is NaN before it is added
    print(time, bodies["position"][cloud].mean(axis=0))
run.report()                       # report.html
