"""A run takes no more memory than `spall check` says, and not much less: a shot at a shield, whose
wall is looked at while debris fly.

SPDX-License-Identifier: BSD-3-Clause
usage: memory.py SPALL, in a folder to write in
"""
import re
import resource
import subprocess
import sys
from pathlib import Path

CASE = """
[materials.metal]
library = "aluminium_6061_t6"
[solid]
courant = 0.2
[[groups]]
name = "wall"
material = "metal"
volume = {shape = "box", size = ["24 mm", "24 mm", "4 mm"], center = [0, 0, "-9 mm"]}
packing = {kind = "fcc", diameter = "0.6 mm", orientation = "random"}
[[groups]]
name = "bumper"
material = "metal"
volume = {shape = "box", size = ["14 mm", "14 mm", "1 mm"]}
packing = {kind = "fcc", diameter = "0.3 mm", orientation = "random"}
[[groups]]
name = "ball"
material = "metal"
volume = {shape = "sphere", diameter = "4 mm", center = [0, 0, "2.9 mm"]}
packing = {kind = "fcc", diameter = "0.3 mm", orientation = "random"}
velocity = [0, 0, -5000]
[[phases]]
name = "shot"
method = "solid"
step = "50 ns"
duration = "0.6 us"
[[shields]]
wall = "wall"
rear = [0, 0, -1]
[output]
series_every = "50 ns"
snapshot_every = "0.2 us"
"""
MOST_TOO_MANY = 2  # times what is taken

Path("shot.toml").write_text(CASE)
told = subprocess.run([sys.argv[1], "run", "shot.toml", "--out", "memory", "--overwrite"],
                      stdout=subprocess.PIPE, text=True, check=True).stdout
foretold = float(re.search(r"at most about ([0-9.]+) MB", told)[1])
taken = 1024e-6 * resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
print(f"foretold {foretold} MB, taken {taken:.4g} MB")
assert taken <= foretold <= MOST_TOO_MANY * taken
