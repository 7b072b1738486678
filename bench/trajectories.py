"""Does the solver's tolerance change where a pile ends? 1,000 steps of a cloud that falls together,
three seeds, at several tolerances, prox weights and numbers of ranks: trajectories.py BUILD_FOLDER

SPDX-License-Identifier: BSD-3-Clause
"""
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import tomllib

from readme import origin, replace_section

here = pathlib.Path(__file__).resolve().parent
CASE = """
title = "A cloud falls together, 1,000 steps"
[materials.rock]
density = "1600 kg/m^3"
[contact]
friction = 0.5
restitution = 0.3
[[groups]]
name = "cloud"
material = "rock"
volume = {shape = "sphere", radius = "44.3 m"}
packing = {kind = "random", radius = "3 m", count = 1000}
[gravity]
method = "direct"
[[phases]]
name = "fall"
step = "10 s"
duration = "10000 s"
"""
MEASURES = [("pile", "gyration_radius", "radius of gyration, m", "{:.3f}"),
            ("pile", "packing_fraction", "packing", "{:.4f}"),
            ("conservation", "dissipated", "dissipated, J", "{:.5g}"),
            ("conservation", "kinetic", "kinetic energy left, J", "{:.1e}"),
            ("conservation", "energy_unexplained", "energy unexplained", "{:.0e}"),
            ("solver", "products_a_step", "products a step", "{:.0f}")]


def run(build, seed, ranks=1, **solver):
    with tempfile.TemporaryDirectory() as folder:
        case = pathlib.Path(folder) / "case.toml"
        case.write_text(CASE)
        command = ["mpirun", "--oversubscribe", "-n", str(ranks), f"{build}/spall", "run",
                   str(case),
                   "--out", f"{folder}/out", "--set", f"seed={seed}"]
        for key, value in solver.items():
            command += ["--set", f"solver.{key}={value}"]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, env=os.environ | {
            "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
            "OMPI_MCA_mpi_yield_when_idle": "1"})
        with open(f"{folder}/out/results.toml", "rb") as file:
            return tomllib.load(file)


def main(build):
    variants = [("default (1e-2, 4e-3)", {})]
    variants += [(f"tolerance {t:g}", {"tolerance": t}) for t in (1e-1, 1e-3, 1e-4)]
    variants += [(f"prox {eps:g}", {"prox": eps}) for eps in (1e-3, 1e-2)]
    variants += [("convex friction", {"friction": "'convex'", "prox": 0})]
    variants += [(f"{n} ranks", {"ranks": n}) for n in (2, 3, 4)]
    lines = [origin(1), "", "| | " + " | ".join(name for _, _, name, _ in MEASURES) + " |",
             "|---|" + "--:|" * len(MEASURES)]
    for name, settings in variants:
        results = [run(build, seed, **settings) for seed in (1, 2, 3)]
        cells = []
        for section, key, _, form in MEASURES:
            values = [result[section][key] for result in results]
            spread = ""
            if key != "products_a_step":
                spread = f" ± {form.format(statistics.stdev(values))}"
            cells.append(form.format(statistics.mean(values)) + spread)
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
        print(lines[-1], flush=True)
    replace_section(here / "README.md", "trajectories", "\n".join(lines))


if __name__ == "__main__":
    main(sys.argv[1])
