# A sweep in a few lines: three cohesions times two seeds, and a table of means.
# SPDX-License-Identifier: BSD-3-Clause
import pandas
import spall

rows = []
for cohesion in ("0.1 N", "1 N", "10 N"):
    for seed in (1, 2):
        run = spall.run("cases/hello/case.toml", f"out/sweep/{cohesion}-{seed}", set={
            "phases.impact.cohesion": cohesion, "seed": seed, "groups.cloud.packing.count": 60})
        rows.append({"cohesion": cohesion, "seed": seed, "beta": run["deflection"]["beta_along"]})

table = pandas.DataFrame(rows).pivot(index="cohesion", columns="seed", values="beta")
print(table.assign(mean=table.mean(axis=1), scatter=table.std(axis=1)).round(3))
assert table.shape == (3, 2) and table.notna().all(axis=None)
