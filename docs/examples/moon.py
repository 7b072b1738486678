import numpy as np
import spall

G, density, apart, swing = 6.67430e-11, 2000.0, 1190.0, np.radians(2)  # SI
planet, bead = 390.0, 10.0                               # m: the radius of both
masses = density * 4 / 3 * np.pi * np.array([planet**3, 3 * bead**3])
mean_motion = np.sqrt(G * masses.sum() / apart**3)
speeds = mean_motion * apart * masses[::-1] / masses.sum() * [-1, 1]

sim = spall.Simulation(
    materials={"rock": {"density": density}},
    shapes={"rod": {"spheres": [{"at": [2 * k, 0, 0], "radius": 1} for k in (-1, 0, 1)]}},
    groups=[{"name": "planet", "material": "rock", "velocity": [0, speeds[0], 0],
             "volume": {"shape": "sphere", "radius": planet}},
            {"name": "moon", "material": "rock", "velocity": [0, speeds[1], 0],
             "spin": [0, 0, mean_motion],
             "volume": {"shape": "sphere", "radius": 3 * bead, "center": [apart, 0, 0]},
             "packing": {"kind": "single", "shape": "rod", "rotation": [0, 0, swing]}}],
    gravity={"method": "direct", "refresh": 1e-5, "near_clumps": 10},
    phases=[{"name": "orbit", "step": 60.0, "duration": 2 * np.pi / mean_motion}])

angles, times = [], []


def measure(sim):
    x, y, z, w = sim.bodies.orientation[1]               # turns the moon's long axis, x
    away = sim.bodies.position[1] - sim.bodies.position[0]
    angle = np.arctan2(2 * (x * y + w * z), w * w + x * x - y * y - z * z)
    angles.append(np.remainder(angle - np.arctan2(away[1], away[0]) + np.pi / 2, np.pi) - np.pi / 2)
    times.append(sim.time)


sim.run_until(2 * np.pi / mean_motion, each=measure)
angles, times = np.array(angles), np.array(times)
k = np.flatnonzero(angles[:-1] * angles[1:] < 0)         # it points to the planet soon after
zeros = times[k] - angles[k] * (times[k + 1] - times[k]) / (angles[k + 1] - angles[k])
period = 2 * (zeros[1] - zeros[0])
# A and C are the moon's least and largest moments: omega = n sqrt(3 (B - A)/C).
expected = 2 * np.pi / (mean_motion * np.sqrt(3 * 8 / (3 * 0.4 + 8)))
print(f"swings in {period:.0f} s, in the closed form {expected:.0f} s")
print(f"by up to {np.degrees(np.max(np.abs(angles))):.2f} degrees")
assert abs(period / expected - 1) < 0.01
