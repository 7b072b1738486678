"""Tables of bench/results/solid.csv in bench/README.md.

SPDX-License-Identifier: BSD-3-Clause
"""
import csv
import statistics
from pathlib import Path

from readme import replace_section

HERE = Path(__file__).parent


def is_random(row):
    return int(row["orientation"]) < 100


def main():
    rows = list(csv.DictReader((HERE / "results/solid.csv").open()))
    lines = ["| up, m/s | Us = c0 + s up | random crystals, mean (least–most) | error | [100] | "
             "[110] | [111] | density "
             "ratio wanted | random | error |", "|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|"]
    shocks = [row for row in rows if row["what"] == "shock"]
    for up in sorted({float(row["speed"]) for row in shocks}):
        here = [row for row in shocks if float(row["speed"]) == up]
        speeds = [float(row["measured"]) for row in here if is_random(row)]
        ratios = [float(row["second"]) for row in here if is_random(row)]
        along = {row["orientation"]: float(row["measured"]) for row in here}
        wanted, dense = float(here[0]["wanted"]), float(here[0]["third"])
        mean, ratio = statistics.mean(speeds), statistics.mean(ratios)
        lines.append(
            f"| {up:g} | {wanted:.0f} | {mean:.0f} ({min(speeds):.0f}–{max(speeds):.0f}) | "
            f"{100 * (mean / wanted - 1):+.1f} % | {along['100']:.0f} | {along['110']:.0f} | "
            f"{along['111']:.0f} | "
            f"{dense:.3f} | {ratio:.3f} | {100 * (ratio / dense - 1):+.1f} % |")
    lines += ["", "| crystal | largest stress of a stretched bar, GPa | at a strain of |",
              "|---|--:|--:|"]
    for row in rows:
        if row["what"] == "tension":
            name = f"seed {row['orientation']}" if is_random(row) else f"[{row['orientation']}]"
            lines.append(
                f"| {name} | {float(row['measured']) / 1e9:.2f} | {100 * float(row['second']):.1f} "
                f"% |")
    lines += ["",
              "| flyer, spacings | crystal | largest tension of a layer, GPa | by the pull-back, "
              "GPa | asked for "
              "| tears so far from the surface, spacings |", "|--:|---|--:|--:|--:|--:|"]
    spall = [row for row in rows if row["what"] == "spall"]
    for length in sorted({float(row["third"]) for row in spall}):
        here = [row for row in spall if float(row["third"]) == length]
        groups = [(f"[{row['orientation']}]", [row]) for row in here if not is_random(row)]
        groups.append(("random, mean (least–most)", [row for row in here if is_random(row)]))
        for name, chosen in groups:
            if not chosen:
                continue

            def spread(key, unit, form):
                values = [float(row[key]) / unit for row in chosen]
                return f"{statistics.mean(values):{form}}" + (
                    f" ({min(values):{form}}–{max(values):{form}})" if len(values) > 1 else "")

            lines.append(f"| {length:g} | {name} | {spread('measured', 1e9, '.2f')} | "
                         f"{spread('second', 1e9, '.2f')} | "
                         f"{float(chosen[0]['wanted']) / 1e9:.2f} | {spread('plane', 1, '.1f')} |")
    replace_section(HERE / "README.md", "solid", "\n".join(lines))


if __name__ == "__main__":
    main()
