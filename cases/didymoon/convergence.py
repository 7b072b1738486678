# The table of jobs/didymoon_convergence.sh: convergence.py FOLDER
# SPDX-License-Identifier: BSD-3-Clause
import pathlib
import sys
import tomllib

NAMES = {"base": "as in case.toml: h = 0.1 ms, tolerance 1e-2, range 1 cm", "step-2": "h = 0.2 ms", "step-0.5": "h = 0.05 ms",
         "step-0.25": "h = 0.025 ms", "tolerance-1e-3": "tolerance 1e-3 during the impact",
         "range-0.5": "range 0.5 cm", "range-2": "range 2 cm", "impulse": 'cohesion_law = "impulse": 50 N s a step'}


def main(folder):
    lines = ["| | dv at 11 s, mm/s | dv at 90 s, mm/s | of it the ejecta | bodies lost | worst relative residual | momentum not closed |",
             "|---|--:|--:|--:|--:|--:|--:|"]
    for name, what in NAMES.items():
        path = folder / name / "results.toml"
        if not path.exists():
            continue
        with open(path, "rb") as file:
            r = tomllib.load(file)
        dv = r["read_out"]["dv"]
        lines.append(f"| {what} | {1e3 * dv[0]:.4g} | {1e3 * dv[-1]:.4g} | {1e3 * r['deflection']['dv_ejecta']:.4g} | {r['ejecta']['count']} | "
                     f"{r['solver']['residual_relative']:.2g} | {r['deflection']['momentum_closure']:.1e} |")
    (pathlib.Path(__file__).parent / "convergence.md").write_text(
        "# Didymoon: what the numbers depend on\nWritten by `jobs/didymoon_convergence.sh`: 1,000 boulders, 50 kg, c = 50 N, all from one "
        "aggregate.\n\n" + "\n".join(lines) + "\n")


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]))
