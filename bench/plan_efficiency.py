"""Plans balls of several sizes for several bodies a rank, and puts the table into docs/scaling.md.

SPDX-License-Identifier: BSD-3-Clause
usage: plan_efficiency.py SPALL [RADIUS_IN_M ...]    of the balls of plan.toml; 0.15 has 20,000
bodies, 0.55 a million
"""
import math
import pathlib
import re
import sys

from compare_plan import CASE, METHODS, blocks, bodies_of, call
from readme import replace_section

HERE = pathlib.Path(__file__).resolve().parent
BODIES_A_RANK = (100, 1000, 10000, 100000)
MACHINE = 10000  # ranks
LATENCY = 2e-6  # s, as the plan assumes


def extrapolated(ranks, rows, efficiency):
    """Efficiency on the machine at as many bodies a rank: only collective calls take longer
    there."""
    collectives, work, telling = (float(rows["all"][k]) for k in (2, 3, 4))
    step = 1e-6 * (work + telling)
    more = collectives * LATENCY * (math.ceil(math.log2(MACHINE)) - math.ceil(math.log2(ranks)))
    return efficiency * step / (step + more)


def main(spall, *radii):
    table = []
    for name, more in METHODS.items():
        for radius in radii or ("0.15", "0.55"):
            changes = ["--set", f"phases.only.method={name.split(',')[0]}", "--set",
                       f"groups.ball.volume.radius={radius}m", *more]
            bodies = bodies_of(spall, changes)
            ranks = [bodies // each for each in BODIES_A_RANK if 2 <= bodies // each <= MACHINE]
            for count, rows, block in blocks(call(spall, "plan", CASE, "--ranks",
                                                  ",".join(map(str, ranks)), *changes)):
                efficiency, limit = re.search(r"efficiency ([\d.]+); most is lost in (.*)",
                                              block).groups()
                each = float(rows["bodies"][0])
                table.append([name, f"{count:,}", f"{each:,.0f}",
                              f"{float(rows['ghosts'][0]) / each:.2f}", rows["near ranks"][1],
                              rows["all"][0], rows["all"][2], efficiency,
                              f"{extrapolated(count, rows, float(efficiency)):.2f}", limit])
    lines = [f"commit {call(HERE / 'commit.sh').strip()}", "",
             "| method | ranks | bodies a rank | ghosts a body | near ranks, most | messages | "
             "collective calls | efficiency "
             f"| extrapolated to {MACHINE:,} ranks | most is lost in |",
             "|---|--:|--:|--:|--:|--:|--:|--:|--:|---|"]
    replace_section(HERE.parent / "docs/scaling.md", "efficiency",
                    "\n".join(lines + ["| " + " | ".join(map(str, row)) + " |" for row in table]))


if __name__ == "__main__":
    main(*sys.argv[1:])
