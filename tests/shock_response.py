"""Shock response spectra of motions whose spectra are known.

SPDX-License-Identifier: BSD-3-Clause
usage: shock_response.py ROOT
"""
import math
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(sys.argv[1]) / "cases/accelerometer"))
import measure  # noqa: E402


def a_step_of_velocity_gives_the_first_swing_of_what_is_let_go():
    time = np.linspace(0, 1e-7, 3)  # short against all periods
    c = math.sqrt(1 - measure.DAMPING**2)
    first_swing = math.exp(-measure.DAMPING / c * math.acos(measure.DAMPING))
    found = measure.spectrum(time, 3 * time / time[-1], 3.0)
    slow = measure.FREQUENCIES < 1e4
    known = 3 * 2 * math.pi * measure.FREQUENCIES * first_swing
    assert np.allclose(found[slow], known[slow], rtol=2e-3), found[slow] / known[slow]


def a_long_push_overshoots_twice_its_acceleration_less_what_damping_takes():
    time = np.linspace(0, 1e-2, 200001)
    found = measure.spectrum(time[::10], 50 * time[::10], 50 * time[-1])
    c = math.sqrt(1 - measure.DAMPING**2)
    known = 50 * (1 + math.exp(-measure.DAMPING / c * math.pi))
    some = (measure.FREQUENCIES > 2e3) & (measure.FREQUENCIES < 2e4)
    assert np.allclose(found[some], known, rtol=2e-3), found[some] / known


def nothing_happens_to_what_moves_on():
    time = np.linspace(0, 1e-4, 101)
    assert np.all(measure.spectrum(time, 5 + 0 * time, 5.0) == 0)


for check in (a_step_of_velocity_gives_the_first_swing_of_what_is_let_go,
              a_long_push_overshoots_twice_its_acceleration_less_what_damping_takes,
              nothing_happens_to_what_moves_on):
    check()
    print(check.__name__)
