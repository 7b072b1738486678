"""What a report's page weighs, how fast it turns, and what watching costs a run: report_page.py
SPALL [--turns 7]

- Size: 100,000 spheres that fly apart, at ten instants, so that no place is like the one before.
- Pictures a second: 10,000 spheres, turned in headless Chromium that draws with the processor.
- Cost of watching: processor time of a run of 10,000 boulders, in turns with nobody and with a page
  that asks as a browser does. The least of all turns is compared: what else a shared machine does
  only adds to it.

Writes docs/report.md.
SPDX-License-Identifier: BSD-3-Clause
"""
import argparse
import json
import os
import pathlib
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import threading
import time
import urllib.request

from readme import origin, replace_section

root = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(root / "tests"))

GAS = """title = "{count} spheres that fly apart"
[materials.rock]
density = "1600 kg/m^3"
[contact]
friction = 0.5
restitution = 0.9
[[groups]]
name = "gas"
material = "rock"
volume = {{shape = "sphere", radius = "{size} m"}}
packing = {{kind = "random", radius = "1 m", count = {count}}}
thermal_velocity = {{rms = "1 m/s", seed = 1}}
[[phases]]
name = "flight"
step = "0.1 s"
duration = "9 s"
[output]
snapshot_every = "1 s"
"""

TURN = """const [done] = arguments, view = spall.views[0], wanted = {whole};
if (wanted) view.drawNow = () => view.render(1);
const start = performance.now(), times = [];
function next(now) {{
  times.push(now);
  view.turn(0.02, 0);
  if (now - start < 8000) requestAnimationFrame(next);
  else done([1000 * (times.length - 1) / (times.at(-1) - times[0]), view.ratio, times.length]);
}}
requestAnimationFrame(next);"""


def make_gas(spall, folder, count):
    case = folder / f"gas_{count}.toml"
    case.write_text(GAS.format(count=count, size=1.5 * count ** (1 / 3)))
    out = folder / f"gas_{count}"
    subprocess.run([spall, "run", case, "--out", out], check=True, stdout=subprocess.DEVNULL)
    begin = time.monotonic()
    subprocess.run([spall, "report", out], check=True, stdout=subprocess.DEVNULL)
    return out / "report.html", time.monotonic() - begin


def descendants(pid):
    """Of a process, itself included."""
    parents = {}
    for stat in pathlib.Path("/proc").glob("[0-9]*/stat"):
        try:
            parents[int(stat.parent.name)] = int(stat.read_text().rsplit(")", 1)[1].split()[1])
        except OSError:  # it has just ended
            continue
    family = {pid}
    while new := {child for child, parent in parents.items() if parent in family} - family:
        family |= new
    return family


def pictures_a_second(page):
    """At the window's own resolution, and as a reader has it, with fewer pixels where pictures come
    late: pictures a second, the share of the resolution, and seconds of processor time a
    picture."""
    from browser import Browser, open_report, set_width
    found = []
    with Browser() as driver:
        driver.set_script_timeout(60)
        for whole in ("true", "false"):
            set_width(driver, 1280)
            open_report(driver, page)
            family = descendants(driver.service.process.pid)
            before = sum(map(processor_seconds, family))
            rate, ratio, count = driver.execute_async_script(TURN.format(whole=whole))
            found.append((rate, ratio, (sum(map(processor_seconds, family)) - before) / count))
    return found


def ask_as_a_page(address, ends):
    """What page/page.js asks, for as long as the run goes on."""
    def ask(name):
        with urllib.request.urlopen(address + name) as answer:
            return answer.read()
    ask("")
    seen, rows, words = set(), 0, ""
    while not ends.wait(3):
        state = json.loads(ask("state"))
        for number in set(state["shown"]) - seen:
            ask(f"snapshots/{number}")
        seen = set(state["shown"])
        if state["rows"] != rows:
            ask("series")
        if state["words"] != words:
            ask("words")
        rows, words = state["rows"], state["words"]


def processor_seconds(pid):
    """Of a process that is still there: its own, in user and system mode."""
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / 100


def turn(spall, out, watched):
    """Seconds: processor time of the run, its wall time, and processor time of the watching."""
    shutil.rmtree(out, ignore_errors=True)  # files of the run before would be taken for its own
    begin, before = time.monotonic(), resource.getrusage(resource.RUSAGE_CHILDREN)
    run = subprocess.Popen([spall, "run", root / "cases/didymoon/case.toml", "--out", out, "--set",
                            "groups.cloud.packing.count=3000", "groups.cloud.volume.radius=63",
                            "output.snapshot_every=500 s"], stdout=subprocess.DEVNULL)
    watching, ends, asking = None, threading.Event(), None
    if watched:
        while not (out / "snapshots/000000.h5").exists() or not (out / "trajectory.h5").exists():
            time.sleep(0.05)
        watching = subprocess.Popen([spall, "watch", out, "--port", "0"], stdout=subprocess.PIPE,
                                    text=True)
        asking = threading.Thread(target=ask_as_a_page,
                                  args=(watching.stdout.readline().split()[0], ends))
        asking.start()
    run.wait()
    wall = time.monotonic() - begin
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    own = 0
    if watched:
        ends.set()
        asking.join()
        own = processor_seconds(watching.pid)
        watching.terminate()
        watching.wait()
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, wall, own


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("spall", type=pathlib.Path)
    parser.add_argument("--turns", type=int, default=7)
    given = parser.parse_args()
    spall, source = given.spall.resolve(), origin(1)  # before hours in which the tree may change
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        large, seconds = make_gas(spall, folder, 100_000)
        megabytes = large.stat().st_size / 1e6
        page, _ = make_gas(spall, folder, 10_000)
        (whole, _, cost), (adapted, ratio, less) = pictures_a_second(page)
        print(whole, cost, adapted, ratio, less, flush=True)
        load = os.getloadavg()[0]
        alone, watched = [], []
        for _ in range(given.turns):
            for turns, is_watched in ((alone, False), (watched, True))[::1 - 2 * (len(alone) % 2)]:
                turns.append(turn(spall, folder / "run", is_watched))
            print(alone[-1], watched[-1], flush=True)
    (least, *_), (beside, *_) = (min(turns) for turns in (alone, watched))
    own = statistics.median(own / wall for _, wall, own in watched)
    replace_section(root / "docs/report.md", "report_page", "\n".join([
        f"{source}.", "", "| what | measured |", "|---|--:|",
        f"| page of 100,000 bodies at ten instants, all moving, with pictures | {megabytes:.1f} "
        f"MB, made in {seconds:.0f} s |",
        f"| a picture of 10,000 bodies at whole resolution, drawn by the processor | "
        f"{1e3 * cost:.0f} ms of processor time |",
        f"| the same while the view turns, at {ratio:.2f} of the resolution | {1e3 * less:.0f} ms "
        f"of processor time |",
        f"| pictures a second, whole and while the view turns, while {load:.0f} processes shared "
        f"the cores | {whole:.0f}, {adapted:.0f} |",
        f"| processor time of a run, alone | {least:.2f} s |",
        f"| the same run while it is watched | {beside:.2f} s ({100 * (beside / least - 1):+.1f} "
        f"%) |",
        f"| processor time of `spall watch` itself, of the run's wall time | {100 * own:.1f} % of "
        f"a core |"]))


if __name__ == "__main__":
    main()
