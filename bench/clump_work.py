"""What a contact of clumps costs beside one of spheres: two piles with about as many contacts.

SPDX-License-Identifier: BSD-3-Clause
usage: clump_work.py SPALL [TURNS]    about a minute a turn; writes bench/README.md

Both are the cloud of cases/pile, of spheres or of boulders of five balls, and settle on one rank.
Steps count from half of the last one's contacts on: seconds in the solver over products and
contacts, as the rows of the series tell.
"""
import pathlib
import statistics
import subprocess
import sys
import tempfile

import h5py
import numpy as np

from readme import origin, replace_section

HERE = pathlib.Path(__file__).resolve().parent
CASE = HERE.parent / "cases/pile/case.toml"
BODIES = {"spheres": (4000, []),
          "boulders of five balls": (3000, ["shapes.boulder={axes = [2, 1.414, 1], count = 5}",
                                            "groups.cloud.packing.shape=boulder"])}


def settle(spall, folder, count, changes):
    """Contacts at the end; ns a contact and product, products a step, their residual."""
    changes = [f"groups.cloud.packing.count={count}", "gravity.method=tree",
               f"groups.cloud.volume.radius=\"{78 * (count / 1000) ** (1 / 3)} m\"",
               "phases.settling.settled_speed=\"0.2 mm/s\"", "output.snapshot_every=0", *changes]
    subprocess.run([spall, "run", CASE, "--out", folder, "--overwrite",
                    *(word for change in changes for word in ("--set", change))],
                   check=True, stdout=subprocess.DEVNULL)
    with h5py.File(folder / "series.h5") as file:
        contacts, products, residual, seconds = (
            file[f"observables/{name}/value"][:]
            for name in ("contacts", "products", "residual_prox", "seconds_solver"))
    # A row tells of the step that begins at its instant, and of the seconds before.
    dense = slice(np.argmax(contacts > contacts[-1] / 2), -1)
    work = np.sum(contacts[dense] * products[dense])
    taken = seconds[-1] - seconds[dense.start]
    return (contacts[-1], 1e9 * taken / work, products[dense].mean(), np.median(residual[dense]))


def main(spall, turns="3"):
    rows = {name: [] for name in BODIES}
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(int(turns)):
            for name, (count, changes) in BODIES.items():
                rows[name].append(settle(spall, pathlib.Path(folder), count, changes))
    lines = [f"{origin(1)}; medians of {turns} turns", "",
             "| pile of | bodies | contacts at the end | ns a contact and product "
             "| products a step | E at the end of a step |", "|---|--:|--:|--:|--:|--:|"]
    cost = {}
    for name, some in rows.items():
        contacts, cost[name], products, residual = (statistics.median(c) for c in zip(*some))
        lines.append(f"| {name} | {BODIES[name][0]:,} | {contacts:,.0f} | {cost[name]:.1f} "
                     f"| {products:.0f} | {residual:.2g} |")
    spheres, clumps = cost.values()
    lines += ["", f"A contact of clumps costs {clumps / spheres:.2f} times one of spheres."]
    replace_section(HERE / "README.md", "clump work", "\n".join(lines))


if __name__ == "__main__":
    main(*sys.argv[1:])
