# Mean speed of a flow by layers, from the last frame of a run.
# SPDX-License-Identifier: BSD-3-Clause
import numpy as np
import spall

*_, (time, bodies) = spall.Run("out/chute").frames()
flow = bodies["group"] == 1                               # group 0 is the bed
height, speed = bodies["position"][flow, 2], bodies["velocity"][flow, 0]
for low in np.arange(0, 12e-3, 2e-3):
    layer = (height >= low) & (height < low + 2e-3)
    if layer.any():
        print(f"{1e3 * low:4.0f} to {1e3 * low + 2:2.0f} mm: {speed[layer].mean():.3f} m/s")
