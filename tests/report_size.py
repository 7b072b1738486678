# A page of the most bodies that it shows, all moving, at ten instants, can be sent by mail.
# SPDX-License-Identifier: BSD-3-Clause
"""report_size.py SPALL, in a folder to write in"""
import json
import re
import subprocess
import sys
from pathlib import Path

MOST = 15e6  # bytes; bench/report_page.py measures what it is
BODIES, INSTANTS = 100_000, 10
SPALL, WORK = Path(sys.argv[1]).resolve(), Path("report_size")
WORK.mkdir(exist_ok=True)
# Spheres at random that fly apart, a radius a step: no place and no speed is like the one before.
(WORK / "gas.toml").write_text(f"""title = "spheres that fly apart"
[materials.rock]
density = "1600 kg/m^3"
[contact]
restitution = 0.9
[[groups]]
name = "gas"
material = "rock"
volume = {{shape = "sphere", radius = "{1.5 * BODIES ** (1 / 3)} m"}}
packing = {{kind = "random", radius = "1 m", count = {BODIES}}}
thermal_velocity = {{rms = "1 m/s", seed = 1}}
[[phases]]
name = "flight"
step = "1 s"
duration = "{INSTANTS - 1} s"
[output]
snapshot_every = "1 s"
""")
subprocess.run([SPALL, "run", WORK / "gas.toml", "--out", WORK / "run", "--overwrite"],
               check=True, stdout=subprocess.DEVNULL)
subprocess.run([SPALL, "report", WORK / "run"], check=True, stdout=subprocess.DEVNULL)
page = WORK / "run/report.html"
run = json.loads(re.search(r"<script type=application/json id=data>(.*?)</script>",
                           page.read_text())[1])["runs"][0]
assert (run["bodies"]["count"], len(run["frames"])) == (BODIES, INSTANTS)
size = page.stat().st_size
print(f"{BODIES} bodies at {INSTANTS} instants: {size / 1e6:.1f} MB")
assert size < MOST
