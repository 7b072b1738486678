#!/usr/bin/python3
"""The first steps of LAMMPS's chute by both programs from one start, grain by grain, into section
first_steps of ../README.md.

SPDX-License-Identifier: BSD-3-Clause
usage: first_steps.py SPALL LMP BENCH FOLDER: BENCH is LAMMPS's bench folder, which holds in.chute;
FOLDER is written into, what LAMMPS has written there is not made anew
"""
import os
import pathlib
import subprocess
import sys

import h5py
import numpy as np

here = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(here.parent))
from readme import origin, replace_section  # noqa: E402

spall, lmp, bench = (pathlib.Path(word).resolve() for word in sys.argv[1:4])
STEPS = [100, 200, 500, 1000, 2000]  # of 1e-4 s
EVERY = 100

os.makedirs(sys.argv[4], exist_ok=True)
os.chdir(sys.argv[4])
text = (bench / "in.chute").read_text().replace("data.chute", str(bench / "data.chute"))
settings = (f"dump all all custom {EVERY} chute.dump id type z vx\n"
            f"dump_modify all sort id format float %.17g\nrun {STEPS[-1]}")
pathlib.Path("chute.in").write_text("\n".join(
    settings if line.split()[:1] == ["run"] else line for line in text.split("\n")))
if not pathlib.Path("chute.done").exists():
    subprocess.run([lmp, "-in", "chute.in"], check=True, stdout=subprocess.DEVNULL)
    pathlib.Path("chute.done").touch()
start = subprocess.run([sys.executable, here.parent / "untuned/data_to_restart.py",
                        bench / "data.chute", "chute"],
                       check=True, capture_output=True, text=True).stdout.split("\n")[:-1]
pathlib.Path("chute.toml").write_text((here.parent / "untuned/chute.toml").read_text())
changes = [*start, f"phases.0.duration={1e-4 * STEPS[-1]!r}",
           f"output.snapshot_every={1e-4 * EVERY!r}"]
subprocess.run([spall, "run", "chute.toml", "--out", "chute", "--overwrite",
                *[w for one in changes for w in ("--set", one)]],
               check=True, stdout=subprocess.DEVNULL)


def lammps_frames():
    """By step: kind, z and v_x of all grains, by ids."""
    lines = open("chute.dump").read().split("\n")
    at = 0
    while at < len(lines) and lines[at]:
        count = int(lines[at + 3])
        rows = np.array([[float(word) for word in line.split()]
                         for line in lines[at + 9:at + 9 + count]])
        yield int(lines[at + 1]), rows[:, 1:]
        at += 9 + count


table = [f"{origin(1)}", "",
         "| steps | mean v_x, Spall, m/s | LAMMPS | ratio - 1 | largest of layers "
         "| rms of single grains' differences |",
         "|--:|--:|--:|--:|--:|--:|"]
with h5py.File("chute/trajectory.h5") as file:
    bodies = file["particles/all"]
    kinds, steps = bodies["group"][()], list(bodies["velocity/step"])
    for step, rows in lammps_frames():
        if step not in STEPS:
            continue
        k = steps.index(step)
        ours = bodies["velocity/value"][k][kinds == 0, 0]  # as in LAMMPS, by ids within a type
        theirs, z = rows[rows[:, 0] == 1][:, 2], rows[rows[:, 0] == 1][:, 1]
        layers = np.histogram_bin_edges(z, np.arange(z.min(), z.max() + 2, 2.0))
        of = [np.histogram(z, layers, weights=v)[0] for v in (ours, theirs)]
        many = np.histogram(z, layers)[0] > 100
        apart = np.abs(of[0] / of[1] - 1)[many].max()
        single = np.sqrt(((ours - theirs) ** 2).mean() / (theirs**2).mean())
        table.append(f"| {step} | {ours.mean():.6f} | {theirs.mean():.6f} "
                     f"| {ours.mean() / theirs.mean() - 1:+.1e} | {apart:.1e} | {single:.1e} |")
replace_section(here.parent / "README.md", "first_steps", "\n".join(table))
print("\n".join(table))
