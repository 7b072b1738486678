"""What an accelerometer on the far end of the bar would tell: its velocity and acceleration, their
shock response spectrum, and what is known of them beforehand.

    /usr/bin/python3 cases/accelerometer/measure.py out/accelerometer

Writes response.png beside this file, and prints the table of README.md.
SPDX-License-Identifier: BSD-3-Clause
"""
import math
import sys
from pathlib import Path

import h5py
import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

HERE = Path(__file__).parent
LENGTH, YOUNG, DENSITY = 80e-3, 68.9e9, 2703.0  # m, Pa, kg/m^3, as in case.toml and its material
GAUGE = 2e-3  # m, of the far end, whose bodies the gauge is fixed to
DAMPING = 0.05  # of critical, as spectra are usually told (Q = 10)
FREQUENCIES = np.geomspace(1e3, 5e5, 120)  # Hz


def read(folder):
    """Time (s); velocity of the gauge, away from the hit end (m/s); of the whole bar in the end;
    and m v/M, that of a bar that takes the particle's momentum alone."""
    with h5py.File(Path(folder) / "trajectory.h5") as file:
        bodies = file["particles/all"]
        time, mass = bodies["position/time"][:], bodies["mass"][:]
        place, bar = bodies["position/value"][0][:, 2], bodies["group"][:] == 0
        far = bar & (place < place[bar].min() + GAUGE)
        gauge = np.array([-np.average(bodies["velocity/value"][k][far, 2], weights=mass[far])
                          for k in range(len(time))])
        first, last = (bodies["velocity/value"][k][:, 2] for k in (0, len(time) - 1))
        whole = bar & (bodies["damage/value"][-1] < 1)
    bare = -np.sum((mass * first)[~bar]) / mass[bar].sum()
    return time, gauge, -np.average(last[whole], weights=mass[whole]), bare


def spectrum(time, velocity, afterwards):
    """m/s^2: of an oscillator of each frequency that stands on the gauge, the largest displacement
    against it, times the square of 2 pi f: its largest acceleration, but for what damping does.
    The gauge goes on `afterwards` (m/s) once the record ends. Exact for a velocity that is straight
    between samples; looked at twenty times a period at least."""
    step = time[1] - time[0]
    omega = 2 * math.pi * FREQUENCIES
    damped = omega * math.sqrt(1 - DAMPING**2)

    def swing(h):
        """What goes on for h (s): the parts of displacement and velocity against the gauge."""
        fade, c, s = np.exp(-DAMPING * omega * h), np.cos(damped * h), np.sin(damped * h) / damped
        return (fade * (c + DAMPING * omega * s), fade * s, -fade * omega**2 * s,
                fade * (c - DAMPING * omega * s))

    def go_on(state, acceleration, parts):
        rest = -acceleration / omega**2
        z, v = state[0] - rest, state[1]
        return rest + parts[0] * z + parts[1] * v, parts[2] * z + parts[3] * v

    looks = math.ceil(20 * FREQUENCIES.max() * step)
    within, state, most = swing(step / looks), (0 * omega, 0 * omega), 0 * omega
    for acceleration in np.diff(velocity) / step:
        for _ in range(looks):
            state = go_on(state, acceleration, within)
            most = np.maximum(most, np.abs(state[0]))
    state = state[0], state[1] - (afterwards - velocity[-1])
    afterwards = swing(1.5 / FREQUENCIES / 400)  # a period and a half
    for _ in range(400):
        state = go_on(state, 0.0, afterwards)
        most = np.maximum(most, np.abs(state[0]))
    return omega**2 * most


def main():
    time, gauge, mean, bare = read(sys.argv[1])
    speed = math.sqrt(YOUNG / DENSITY)
    known = 2 * LENGTH / speed
    peak = np.argmax(gauge[time < known])
    arrival = np.interp(gauge[peak] / 2, gauge[:peak + 1], time[:peak + 1])
    # The pulse comes back: where the record is most like itself. Whole periods have the mean.
    lags = np.arange(int(0.7 * known / (time[1] - time[0])), int(1.4 * known / (time[1] - time[0])))
    same = [np.mean(gauge[:-lag] * gauge[lag:]) for lag in lags]
    best = int(np.argmax(same))
    left, middle, right = same[best - 1:best + 2]
    period = (lags[best] + (left - right) / (2 * (left - 2 * middle + right))) * (time[1] - time[0])
    counted = (time > arrival - period / 2) & (time <= arrival + 3.5 * period)
    over_periods = gauge[counted].mean()
    peaks = spectrum(time, gauge, mean)
    slow = peaks[0] / (2 * math.pi * FREQUENCIES[0])
    # An oscillator of this damping, at rest on a base that is suddenly at 1 m/s.
    c = math.sqrt(1 - DAMPING**2)
    step_response = math.exp(-DAMPING / c * math.acos(DAMPING))
    print("| | found | known | |\n|---|--:|--:|---|")
    print(f"| the pulse comes back after, us | {1e6 * period:.1f} | {1e6 * known:.1f} | 2 L/c |")
    print(f"| mean velocity at the gauge over four periods, m/s | {over_periods:.3f} "
          f"| {mean:.3f} | "
          "momentum of the bar over its mass |")
    print(f"| spectrum at {FREQUENCIES[0]:g} Hz over 2 pi f, m/s | {slow:.3f} | "
          f"{step_response * mean:.3f} | a step of the bar's velocity |")
    print(f"| velocity of the bar over m v/M | {mean / bare:.3f} | 1 or more | what is thrown back "
          "adds to it |")
    print(f"| largest velocity at the gauge, m/s | {gauge.max():.2f} | | |")
    steepest = np.abs(np.diff(gauge)).max() / (time[1] - time[0])
    print(f"| largest acceleration there, g | {steepest / 9.80665:.3g} | | |")
    figure, axes = plt.subplots(1, 2, figsize=(10, 3.6), layout="constrained")
    axes[0].plot(1e6 * time, gauge, linewidth=1)
    axes[0].axhline(mean, color="0.6", linewidth=0.8, label="the bar's mean")
    axes[0].set(xlabel="time (µs)", ylabel="velocity of the far end (m/s)")
    axes[0].legend(fontsize=8)
    axes[1].loglog(FREQUENCIES / 1e3, peaks / 9.80665, linewidth=1.2)
    axes[1].loglog(FREQUENCIES / 1e3, 2 * math.pi * FREQUENCIES * step_response * mean / 9.80665,
                   "--", color="0.6", linewidth=0.8, label="a step of the bar's velocity")
    axes[1].set(xlabel="frequency (kHz)", ylabel="shock response (g)")
    axes[1].legend(fontsize=8)
    figure.savefig(HERE / "response.png", dpi=110)


if __name__ == "__main__":
    main()
