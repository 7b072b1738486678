# Two runs beside each other: what friction changes in a pile, as a table and body by body.
# SPDX-License-Identifier: BSD-3-Clause
import numpy as np
import pandas
import spall

small = {"groups.cloud.packing.count": 60, "groups.cloud.volume.radius": "6 m"}
runs = {friction: spall.run("cases/hello/case.toml", f"out/friction-{friction}", overwrite=True,
                            set={**small, "contact.friction": friction})
        for friction in (0, 0.5)}

table = pandas.DataFrame({f"friction {name}": {
    "half-mass radius, m": run["pile"]["half_mass_radius"],
    "filled": run["pile"]["packing_fraction"],
    "largest diameter, m": run["pile"]["extent"]} for name, run in runs.items()})
print(table.to_string(float_format="%.4g"))

ends = []
for run in runs.values():
    *_, (time, bodies) = run.frames()                     # the last frame
    rows = np.argsort(bodies["id"])                       # rows may differ, ids are the same
    ends.append(bodies["position"][rows])
apart = np.linalg.norm(ends[0] - ends[1], axis=1)
print(f"the same bodies end {np.median(apart):.2f} m apart (median): compare means, not bodies")
