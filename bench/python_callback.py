"""What a Python function between steps costs.

usage: python_callback.py [--turns 200], with build/release/python in PYTHONPATH

Steps of 10,000 bodies: grains at rest, whose steps are the shortest that have contacts, and
boulders that gather by their own gravity. Short blocks of steps are made in turns without a
function, with one that does nothing, and with one that asks for an array. Compared is the processor
time of a step, turn by turn: of the differences within a turn the median is told, and the quarter
and three quarters of them.

Writes docs/python.md.
SPDX-License-Identifier: BSD-3-Clause
"""
import argparse
import pathlib
import statistics
import time

import spall

from readme import origin, replace_section

ROOT = pathlib.Path(__file__).resolve().parent.parent
FOR_EVER = 1e9  # s
FUNCTIONS = {"none": None, "nothing": lambda sim: None, "array": lambda sim: sim.bodies.position}


def boulders(step):
    return spall.Simulation(
        materials={"rock": {"density": "1600 kg/m^3"}},
        contact={"friction": 0.5, "restitution": 0.3},
        gravity={"method": "tree"},
        groups=[{"name": "cloud", "material": "rock",
                 "volume": {"shape": "sphere", "radius": "32 m"},
                 "packing": {"kind": "random", "radius": "1 m", "count": 10_000}}],
        phases=[{"name": "gather", "step": step, "duration": FOR_EVER}])


def grains(step):
    return spall.Simulation(
        materials={"grain": {"density": 2500, "youngs_modulus": "5 MPa"}},
        contact={"friction": 0.5, "restitution": 0.3},
        penalty={"model": "hertz"}, gravity={"uniform": [0, 0, -9.81]}, planes=[{}],
        groups=[{"name": "layers", "material": "grain",
                 "volume": {"shape": "box", "size": ["50 mm", "50 mm", "4 mm"],
                            "center": [0, 0, "2 mm"]},
                 "packing": {"kind": "simple_cubic", "diameter": "1 mm"}}],
        phases=[{"name": "rest", "method": "penalty", "step": step, "duration": FOR_EVER}])


def seconds_a_step(sim, step, count, function):
    begin, before = time.process_time(), sim.steps
    sim.run_until(sim.time + count * step, each=function)
    return (time.process_time() - begin) / (sim.steps - before)


def row(what, make, step, count, turns):
    sim = make(step)
    for function in FUNCTIONS.values():  # what is needed for the first time
        seconds_a_step(sim, step, count, function)
    found = {name: [] for name in FUNCTIONS}
    for turn in range(turns):
        for name in (list(FUNCTIONS) * 2)[turn % len(FUNCTIONS):][:len(FUNCTIONS)]:
            found[name].append(seconds_a_step(sim, step, count, FUNCTIONS[name]))
    bare = statistics.median(found["none"])
    cells = [f"{len(sim.bodies):,} {what}", f"{turns} turns of {count}", f"{1e3 * bare:.3g} ms"]
    for name in ("nothing", "array"):
        low, middle, high = statistics.quantiles(
            (a - b for a, b in zip(found[name], found["none"])), n=4)
        cells.append(f"{1e6 * middle:+.1f} µs ({1e6 * low:+.1f} to {1e6 * high:+.1f}): "
                     f"{100 * middle / bare:+.2f} %")
    print(cells, flush=True)
    return "| " + " | ".join(cells) + " |"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--turns", type=int, default=200)
    turns = parser.parse_args().turns
    source = origin(1)
    replace_section(ROOT / "docs/python.md", "callback", "\n".join([
        f"{source}; processor time, medians and quarters of the turns.", "",
        "| bodies | measured | a step | a function that does nothing "
        "| one that asks for an array |",
        "|---|---|--:|--:|--:|",
        row("grains at rest", grains, 2e-6, 10, turns),
        row("boulders that gather", boulders, 1.0, 1, turns // 4)]))


if __name__ == "__main__":
    main()
