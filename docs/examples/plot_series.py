# A curve from the series of a run: kinetic energy and contacts while a cloud falls together.
# SPDX-License-Identifier: BSD-3-Clause
import matplotlib
import spall

matplotlib.use("Agg")
from matplotlib import pyplot

run = spall.run("cases/hello/case.toml", "out/gather", overwrite=True, set={
    "groups.cloud.packing.count": 60, "groups.cloud.volume.radius": "6 m"})
series = run.series
series = series[series.time < 1.2 * series.time[series.kinetic[:-200].idxmax()]]

figure, axes = pyplot.subplots(layout="constrained")
axes.plot(series.time, series.kinetic, label="kinetic energy, J")
axes.set_xlabel("time, s")
axes.set_ylabel("kinetic energy, J")
beside = axes.twinx()
beside.plot(series.time, series.contacts, "C1", linewidth=0.8)
beside.set_ylabel("contacts", color="C1")
figure.savefig("gather.png", dpi=120)
print(f"{len(series)} rows, columns: {', '.join(series.columns[:6])}, ...")
