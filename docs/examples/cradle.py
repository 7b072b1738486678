# Newton's cradle: the same five balls by rigid contact and by Hertz's springs, and what differs.
# SPDX-License-Identifier: BSD-3-Clause
import spall


def hit(method, step, gap=0.0):
    """Velocities along the row after ball 0 has met the four others at 1 m/s."""
    sim = spall.Simulation(
        materials={"steel": {"density": 7800, "youngs_modulus": "1 GPa"}},
        contact={"restitution": 1},
        penalty={"model": "hertz"},
        phases=[{"name": "hit", "method": method, "step": step, "duration": "60 ms"}])
    for k in range(5):
        away = 0.01 if k == 0 else -k * gap               # ball 0 comes from 1 cm away
        sim.add("steel", radius=0.02, position=(0.04 * k - away, 0, 0),
                velocity=(1 if k == 0 else 0, 0, 0))
    sim.run_until(0.06)
    frame = sim.bodies.frame()
    return frame.velocity_x.to_numpy()


for name, velocities in {
        "rigid, touching": hit("nonsmooth", "0.1 ms"),
        "rigid, 0.5 mm apart": hit("nonsmooth", "0.1 ms", gap=0.0005),
        "Hertz, touching": hit("penalty", "2 us")}.items():
    print(f"{name:20}", *(f"{v:6.3f}" for v in velocities))
    assert abs(sum(velocities) - 1) < 1e-6                # momentum
