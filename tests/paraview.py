"""ParaView's script frames a run: its picture shows the bodies in the middle. Skipped where
ParaView is not.

SPDX-License-Identifier: BSD-3-Clause
usage: paraview.py SPALL CASES SCRIPT, in a folder to write in
"""
import shutil
import subprocess
import sys
from pathlib import Path

spall, cases, script = sys.argv[1:]
if not (shutil.which("pvpython") and shutil.which("xvfb-run")):
    sys.exit(77)
out = Path("paraview_run")
subprocess.run([spall, "run", f"{cases}/hello/case.toml", "--out", out, "--overwrite", "--set",
                "phases.aggregation.duration=100", "--set", "phases.evolution.duration=1", "--set",
                'read_out=["1 s"]'],
               check=True, stdout=subprocess.DEVNULL)
# A server that resets itself when its last client leaves would refuse ParaView's second connection.
subprocess.run(["xvfb-run", "--auto-servernum", "--server-args=-screen 0 1280x1024x24 -noreset",
                "pvpython", script, out], check=True)
assert "<ServerManagerState" in (out / "scene.pvsm").read_text()

from matplotlib import image  # noqa: E402

is_body = (image.imread(out / "scene.png")[..., :3] < 0.9).any(axis=2)
height, width = is_body.shape
middle = is_body[height // 4:3 * height // 4, width // 4:3 * width // 4].mean()
edge = is_body[:height // 20].mean()
assert middle > 0.3 and edge < 0.1, (middle, edge)
print(f"bodies fill {middle:.0%} of the middle, {edge:.0%} of the upper edge")
