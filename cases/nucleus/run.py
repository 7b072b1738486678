# The nucleus and its boulders, settled once and hit once for each cohesion, beside the thesis and
# momentum.
# SPDX-License-Identifier: BSD-3-Clause
"""run.py [--only-table]: runs what is missing in out/, writes results.md beside this script."""
import pathlib
import sys
import tomllib

HERE = pathlib.Path(__file__).parent
sys.path.append(str(HERE.parent))
from program import spall  # noqa: E402

# Tables 3.18 and 3.19 of "Discrete Models of Hypervelocity Impacts of Orbiting Objects": dv (m/s),
# v_ejecta (m/s)
THESIS = {400: (0.0010, 13.9917), 500: (0.0015, 22.5372), 1000: (0.00066, 2.2168),
          2000: (0.00056, 0.5988)}


def main():
    if "--only-table" not in sys.argv:
        if not pathlib.Path("out/nucleus/after_aggregation.h5").exists():
            spall("run", "cases/nucleus/case.toml", "--out", "out/nucleus", ranks=2, shows=True)
        for c in THESIS:
            if not pathlib.Path(f"out/nucleus-{c}/results.toml").exists():
                spall("resume", "out/nucleus/after_aggregation.h5", "--out", f"out/nucleus-{c}",
                      changes=[f"phases.impact.cohesion={c} N"], ranks=2, shows=True)
    lines = ["| c, N | dv at 11 s, mm/s | dv at 90 s, mm/s | thesis | what the thesis's ejecta "
             "allow | m v / M | m v (1 + e) / M | bodies lost | "
             "their mass, kg | v_ejecta, m/s | thesis | momentum not closed, of m v |",
             "|--:|" + "--:|" * 11]
    for c, (dv, v_ejecta) in THESIS.items():
        path = pathlib.Path(f"out/nucleus-{c}/results.toml")
        if not path.exists():
            continue
        with open(path, "rb") as file:
            r = tomllib.load(file)
        d, mass, boulder = r["deflection"], r["pile"][
            "mass"], 1600 * 4 / 3 * 3.141592653589793 * 1.7**3
        allowed = d["dv_elastic"] + boulder * v_ejecta / mass
        lines.append(f"| {c} | {1e3 * r['read_out']['dv'][0]:.4g} | {1e3 * d['dv']:.4g} | "
                     f"{1e3 * dv:.3g} | {1e3 * allowed:.3g} | "
                     f"{1e3 * d['dv_plastic']:.4g} | {1e3 * d['dv_elastic']:.4g} | "
                     f"{r['ejecta']['count']} | {r['ejecta']['mass']:.3g} | "
                     f"{r['ejecta']['v_ejecta']:.4g} | {v_ejecta:.4g} | "
                     f"{d['momentum_closure']:.1e} |")
    (HERE
     / "results.md").write_text(
         "# The nucleus: the impacts, beside the thesis\nWritten by `cases/nucleus/run.py`.\n\n"
         + "\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
