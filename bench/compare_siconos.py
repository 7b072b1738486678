#!/usr/bin/python3
"""Spall beside Siconos on FCLIB's local problems; every residual by Spall's own function.

usage: bench/compare_siconos.py BUILD_FOLDER problem.hdf5 …
Writes bench/results/siconos.csv and the table in bench/README.md. Siconos: apt-get install siconos.
For each method and tolerance of Siconos: seconds of its driver and the E that its impulses leave;
then the seconds that `spall solve` needs to that E or below, in turns, the median of three. About
two minutes for two problems of 2,900 contacts.

SPDX-License-Identifier: BSD-3-Clause
"""
import csv
import pathlib
import shutil
import statistics
import subprocess
import sys
import tempfile

import h5py
import numpy as np

HERE = pathlib.Path(__file__).parent
TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
METHODS = {"NSGS": 20000, "ADMM": 20000, "NSN_AC": 500, "VI_EG": 20000}
LONGEST = 40  # s


def to_binary(source, target):
    with h5py.File(source) as file:
        w = file["fclib_local/W"]
        size, kind = int(w["m"][0]), int(w["nz"][0])
        pointers, indices, values = (w[k][()] for k in "pix")
        major = (np.repeat(np.arange(size), np.diff(pointers)) if kind < 0 else pointers[:kind])
        rows, columns = (indices, major) if kind == -1 else (major, indices)
        used = len(major)
        mu, q = (file["fclib_local/vectors"][k][()] for k in ("mu", "q"))
    with open(target, "wb") as out:
        np.array([len(mu), used], np.int64).tofile(out)
        rows[:used].astype(np.int32).tofile(out)
        columns[:used].astype(np.int32).tofile(out)
        for array in (values[:used], q, mu):
            array.astype(np.float64).tofile(out)


def spall(build, problem, *arguments):
    text = subprocess.run([f"{build}/spall", "solve", str(problem), *arguments], check=True,
                          capture_output=True, text=True).stdout
    words = {line.split()[0]: line.split()[1] for line in text.splitlines()}
    return float(words["seconds"]), float(words["E"]), int(words["products"]), words["converged"]


def compare(build, driver, problem, folder, rows):
    binary, solution = folder / "problem.bin", folder / "solution.bin"
    judged = folder / "judged.hdf5"
    to_binary(problem, binary)
    shutil.copy(problem, judged)
    for method, most in METHODS.items():
        for tolerance in TOLERANCES:
            times, ours = [], []
            try:
                for turn in range(3):
                    text = subprocess.run(
                        [str(driver), str(binary), method, str(tolerance), str(most),
                         str(solution)],
                        check=True, capture_output=True, text=True, timeout=LONGEST).stdout.split()
                    at = text.index("seconds")
                    times.append(float(text[at + 1]))
                    if turn == 0:
                        with h5py.File(judged, "r+") as file:
                            if "solution" in file:
                                del file["solution"]
                            file["solution/r"] = np.fromfile(solution)
                        residual = spall(build, judged, "--evaluate")[1]
                    ours.append(spall(build, problem, "--tol", str(min(residual, 1.0)),
                                      "--max-products", "20000"))
            except (subprocess.TimeoutExpired, subprocess.CalledProcessError) as error:
                print(f"{problem} {method} {tolerance}: {type(error).__name__}", file=sys.stderr)
                break
            best = statistics.median(o[0] for o in ours)
            rows.append({"problem": pathlib.Path(problem).stem, "method": method,
                         "tolerance": tolerance, "iterations": int(text[at + 3]),
                         "siconos_s": statistics.median(times), "siconos_E": residual,
                         "spall_s": best, "spall_E": ours[0][1], "spall_products": ours[0][2],
                         "spall_reached": ours[0][3]})
            print(rows[-1], flush=True)
            if statistics.median(times) > LONGEST / 3:
                break


def table(rows):
    lines = ["| problem | Siconos | its tolerance | its E | its s | Spall s | products | ratio |",
             "|---|---|--:|--:|--:|--:|--:|--:|"]
    for r in rows:
        reached = r["spall_reached"] == "yes"
        ours = (f"{r['spall_s']:.3g} | {r['spall_products']} | {r['siconos_s'] / r['spall_s']:.1f}"
                if reached else f"not reached ({r['spall_E']:.1e} in {r['spall_s']:.3g}) | "
                f"{r['spall_products']} | –")
        lines.append(f"| {r['problem']} | {r['method']} | {r['tolerance']:.0e} |"
                     f" {r['siconos_E']:.1e} | {r['siconos_s']:.3g} | {ours} |")
    return "\n".join(lines)


def main():
    build, problems = sys.argv[1], sys.argv[2:]
    if not pathlib.Path("/usr/include/siconos/numerics").exists():
        print("skipped: Siconos is not installed (apt-get install siconos)")
        return
    rows = []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        driver = folder / "siconos_solve"
        subprocess.run(["g++", "-O2", "-I/usr/include/siconos",
                        str(HERE / "peers/siconos_solve.cpp"),
                        "-o", str(driver), "-lsiconos_numerics"], check=True)
        for problem in problems:
            compare(build, driver, problem, folder, rows)
    from readme import replace_section
    commit = subprocess.run([HERE / "commit.sh"], check=True, capture_output=True,
                            text=True).stdout.strip()
    with open(HERE / "results/siconos.csv", "w", newline="") as file:
        file.write(f"# commit {commit}\n")
        writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    replace_section(HERE / "README.md", "siconos", table(rows))


if __name__ == "__main__":
    main()
