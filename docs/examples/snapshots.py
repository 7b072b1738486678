# Reads what a run wrote by h5py alone: fields, units, names of groups, and the fastest bodies.
# SPDX-License-Identifier: BSD-3-Clause
import h5py
import numpy as np
import spall

spall.run("cases/hello/case.toml", "out/hello", overwrite=True, set={
    "groups.cloud.packing.count": 60, "groups.cloud.volume.radius": "6 m"})

with h5py.File("out/hello/trajectory.h5") as file:
    bodies = file["particles/all"]
    times = bodies["position/time"][:]
    print(f"{len(times)} frames, the last at {times[-1]:.0f} s")
    for name in ("position", "velocity", "radius"):
        data = bodies[name]["value"] if isinstance(bodies[name], h5py.Group) else bodies[name]
        print(f"{name:10} {str(data.shape):16} {data.attrs['unit'].decode()}")

    there = bodies["id/value"][-1] >= 0                   # all, once the impactor is added
    speed = np.linalg.norm(bodies["velocity/value"][-1], axis=1)
    names = {number: name for name, number in h5py.check_enum_dtype(bodies["group"].dtype).items()}
    for row in np.argsort(-speed * there)[:3]:
        print(f"body {row} of {names[bodies['group'][row]]}: {speed[row]:.3g} m/s")
