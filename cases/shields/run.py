"""Shoots at the shields of shots.csv with method = "solid" and keeps what became of the wall.

    python3 cases/shields/run.py --plan         which shots, in which order, and what they cost
    python3 cases/shields/run.py --until 16:45  runs what is missing until then; the same line goes
                                                on later
    python3 cases/shields/run.py --trial 93     tries the machinery on a shot that the rule leaves
                                                out

Which shots are run, in which order and how finely is told by README.md. One run follows the other;
each has a folder below --out, and what it gave is a line of results.csv.
SPDX-License-Identifier: BSD-3-Clause
"""
import argparse
import csv
import datetime
import hashlib
import math
import os
import re
import subprocess
import sys
import tempfile
import threading
import time
import tomllib
from dataclasses import dataclass, replace
from pathlib import Path

from equations import STEEPEST_CHEAP, is_cheap, read_shots

HERE = Path(__file__).parent
ROOT = HERE.parent.parent
RESULTS = HERE / "results.csv"
SECOND = HERE / "second_look.csv"

# Metals of the table and the constants that stand for them. A bumper or a wall has its own alloy's,
# of a temper that differs by stretching alone; the ball's are those of the nearest alloy whose
# constants are known.
PLATES = {"AA6061-T6": "aluminium_6061_t6", "AA6061-T651": "aluminium_6061_t6",
          "AA2024-T3": "aluminium_2024_t351"}
BALLS = {**PLATES, "AA2017-T4": "aluminium_2024_t351"}
# Of shots beside the rule: trials, which count nowhere, and balls of another material.
OTHERS = {"Cu": "copper", "Ti": "titanium_6al_4v", "Nylon": "nylon_66",
          "AA7075-T6": "aluminium_7075_t651"}
STAND_IN = "aluminium_6061_t6"
# Of 7075-T651 it is not known here: it has that of 6061-T6.
LACKING = {"aluminium_7075_t651": 'solid = {spall_strength = "1.2 GPa"}'}

# What tells runs of the same shot apart: bodies across the ball, and of the wall on the ball's
# diameter, at least; the seed of the crystals' orientations; the end, of the duration that FLIGHT
# and RINGING give; and how far the cloud that the wall must cover spreads, over the stand-off.
# What RULE costs decides which shots are run, and when.
RULE = argparse.Namespace(across=6.0, wall_across=6.0, seed=1, end=1.0, spread=0.2)
# Unless others are asked for.
FINE = argparse.Namespace(**vars(RULE) | {"across": 18.0, "end": 0.5, "spread": 0.35})
BUMPER_LAYERS, WALL_LAYERS = 2, 3  # at least
BUMPER_WIDTH = 3  # ball diameters
CHOSEN_WIDTH = 4  # of bumpers when shots were chosen by their cost
WALL_RIM = 1.5  # ball diameters that the wall is wider than that, on each side, or its thickness
FLIGHT = 2.5  # times that which the ball would need at its speed from the bumper to the wall
DRAWS = 5  # of crystals, until the wall's have its mass
RINGING = 40  # times that which sound needs through the wall
MOST_COMING = 0.01  # of the energy that flies: a wall that more has not met yet has not held
LONGER = 2  # times as long, a run in which a wall so held is made again
COURANT = 0.2  # steps are parted by it
SOUND = 5350  # m/s, of aluminium: where a duration or a cost is estimated
SLOPE = 1.34  # of aluminium's shock speed
DEAREST = 4e9  # body-steps: shots that need more are left out
DEAREST_BESIDE = 2e9  # the same, by the second rule
TRIED = {609, 611, 646}  # by former laws, as trials: README.md tells of them
CHEAPEST = 1.25e8  # body-steps, of the first class of cost; it doubles from class to class
DRAWN_BY = "shields"  # in a class the order is drawn by a hash of this word and the row


@dataclass(frozen=True)
class Setting:
    """A shot as it is simulated, in m and s; z points against the ball's flight, the bumper's front
    is at 0."""
    ball: float  # spacings
    bumper: float
    wall: float
    length: float  # of the wall, along the plane of flight
    width: float
    middle: float  # of the wall along x: an oblique cloud arrives beside the axis
    duration: float
    bodies: float  # estimated
    steps: float

    @property
    def cost(self):
        return self.bodies * self.steps


def set_up(shot, options):
    """`options`: as RULE has them. The bumper's bodies are as large as the ball's at most."""
    d, t, s, w, v = (shot.diameter / 100, shot.bumper / 100, shot.standoff / 100, shot.wall / 100,
                     1000 * shot.speed)
    angle = math.radians(shot.angle)
    ball = d / options.across
    bumper, wall = min(ball, t / BUMPER_LAYERS), min(d / options.wall_across, w / WALL_LAYERS)
    width = 2 * (max(WALL_RIM * d, w) + options.spread * s)
    sideways = s * math.tan(angle)
    duration = options.end * (2 * d / v + FLIGHT * s / (v * math.cos(angle)) + RINGING * w / SOUND)
    per_volume = math.sqrt(2)  # spheres of fcc in a cube of their spacing
    disc = 1 if angle else math.pi / 4
    bodies = per_volume * (math.pi / 6 * d**3 / ball**3
                           + disc * (CHOSEN_WIDTH * d)**2 / math.cos(angle) * t / bumper**3
                           + disc * (width + sideways) * width * w / wall**3)
    step = COURANT * min(ball, bumper, wall) / (SOUND + 4 * SLOPE * v)
    return Setting(ball, bumper, wall, width + sideways, width, sideways / 2, duration, bodies,
                   duration / step)


def class_of(setting):
    """0 up to CHEAPEST, and one more each time that the cost doubles."""
    return max(0, math.ceil(math.log2(setting.cost / CHEAPEST)))


def rule(shot):
    """The setting by whose cost shots are chosen and put into their order."""
    return set_up(shot, RULE)


def has_known_metals(shot):
    return shot.metals[0] in BALLS and all(metal in PLATES for metal in shot.metals[1:])


def in_order(some):
    """By classes of cost, and drawn within each."""
    def place(shot):
        return (class_of(rule(shot)),
                hashlib.sha256(f"{DRAWN_BY} {shot.row}".encode()).hexdigest())

    return sorted(some, key=place)


def chosen(shots):
    """The shots of the rule, in its order."""
    return in_order([shot for shot in shots if is_cheap(shot) and has_known_metals(shot)
                     and rule(shot).cost <= DEAREST])


def beside(shots):
    """The shots of the second rule, in its order."""
    return in_order([shot for shot in shots if not is_cheap(shot) and has_known_metals(shot)
                     and shot.angle <= STEEPEST_CHEAP and shot.bumper <= shot.diameter
                     and rule(shot).cost <= DEAREST_BESIDE and shot.row not in TRIED])


def volume(shape, length, width, height, middle, z):
    where = f"center = [{middle:.9g}, 0, {z:.9g}]"
    if shape == "cylinder":
        return f'{{shape = "cylinder", diameter = {width:.9g}, height = {height:.9g}, {where}}}'
    return f'{{shape = "box", size = [{length:.9g}, {width:.9g}, {height:.9g}], {where}}}'


def case_of(shot, setting, options, grown=1, draw=0):
    """`grown`: times which the ball and its spacing are as large, for its mass. `draw`: how often
    crystals have been turned anew."""
    d, t, s, w, v = (shot.diameter / 100, shot.bumper / 100, shot.standoff / 100, shot.wall / 100,
                     1000 * shot.speed)
    angle = math.radians(shot.angle)
    shape = "box" if angle else "cylinder"
    # Of its centre from the bumper.
    clear = grown * d / 2 + 1.05 * max(setting.ball, setting.bumper)
    bumper = BUMPER_WIDTH * d
    libraries = [(known | OTHERS).get(metal, STAND_IN)
                 for known, metal in zip((BALLS, PLATES, PLATES), shot.metals)]
    groups = [
        ("wall", setting.wall,
         volume(shape, setting.length, setting.width, w, setting.middle, -t - s - w / 2), None),
        ("bumper", setting.bumper,
         volume(shape, bumper / math.cos(angle), bumper, t, 0, -t / 2), None),
        ("ball", setting.ball * grown, f'{{shape = "sphere", diameter = {d * grown:.9g}, '
                               f"center = [{-clear * math.tan(angle):.9g}, 0, {clear:.9g}]}}",
         [v * math.sin(angle), 0, -v * math.cos(angle)])]
    text = [f'title = "{shot.source} {shot.name}: {shot.diameter:g} cm at {shot.speed:g} km/s and '
            f'{shot.angle:g} degrees, {shot.metals[0]} on {shot.metals[1]} and {shot.metals[2]}"',
            f"seed = {1000 * options.seed + shot.row + 1_000_000 * draw}"]
    for part, library in zip(("ball", "bumper", "wall"), libraries):
        text += ["", f"[materials.{part}]", f'library = "{library}"', LACKING.get(library, "")]
    text += ["", "[solid]", f"courant = {COURANT}"]
    for name, spacing, filled, velocity in groups:
        text += ["", "[[groups]]", f'name = "{name}"', f'material = "{name}"', f"volume = {filled}",
                 f'packing = {{kind = "fcc", diameter = {spacing:.9g}, orientation = "random"}}']
        if velocity:
            text += [f"velocity = [{', '.join(f'{x:.9g}' for x in velocity)}]"]
    text += ["", "[[phases]]", 'name = "shot"', 'method = "solid"',
             f"step = {setting.duration / 200:.6g}", f"duration = {setting.duration:.6g}",
             "", "[[shields]]", 'wall = "wall"', "rear = [0, 0, -1]",
             "", "[output]", f"series_every = {setting.duration / 50:.6g}",
             f"snapshot_every = {setting.duration / 10:.6g}", ""]
    return "\n".join(text)


COLUMNS = ["row", "shot", *vars(RULE), "verdict", "margin", "margin_before",
           "still_coming", "opening_at_edge", "hole_mm", "spall_mg", "ball_mg",
           "largest_met_j", "met_size_mm", "met_rotation", "met_velocity_m_s", "largest_passed_j",
           "energy_unexplained", "bodies", "seconds", "commit"]


def ball_of(shot):
    """kg"""
    return 1000 * shot.density[0] * math.pi / 6 * (shot.diameter / 100)**3


def mass_of_ball(told):
    """kg, as `spall check` and `run` tell it: a lattice has its own number of sites in a sphere."""
    return float(re.search(r"^  ball +\d+ +\S+ +\S+ +(\S+)", told, re.M)[1])


def is_of(line, options):
    """Whether a line of results.csv is of this setting."""
    return all(float(line[key]) == getattr(options, key) for key in vars(RULE))


def ended_early(line):
    """Whether too much had not met the wall, of a run that tells a verdict. What failed has."""
    return line["verdict"] == "held" and float(line["still_coming"]) > MOST_COMING


def in_a_cell(numbers):
    return " ".join(f"{x:.4g}" for x in numbers)


def run(options, shot):
    """A line of results.csv. A run that fails or takes too long has no verdict, and says so in its
    place. One that ends too early is made again, for longer."""
    setting = set_up(shot, options)
    line = run_for_its_time(options, shot, setting)
    if ended_early(line):
        longer = replace(setting, duration=LONGER * setting.duration)
        line = run_for_its_time(options, shot, longer)
    return line


def run_for_its_time(options, shot, setting):
    """A line of results.csv, of one run."""
    chosen_by = {key: f"{getattr(options, key):g}" for key in vars(RULE)}
    folder = options.out / "-".join([str(shot.row), *chosen_by.values()])
    folder.mkdir(parents=True, exist_ok=True)
    case = folder / "shot.toml"
    line = {"row": shot.row, "shot": shot.name, **chosen_by}
    for draw in range(DRAWS):  # a crystal that lies along the wall's faces may lack a layer
        case.write_text(case_of(shot, setting, options, draw=draw))
        checked = subprocess.run([options.program, "check", case], capture_output=True, text=True)
        if checked.returncode == 0:
            break
    else:
        print(checked.stderr, end="", file=sys.stderr)
        return line | {"verdict": "failed", "seconds": "0"}
    grown = (ball_of(shot) / mass_of_ball(checked.stdout))**(1 / 3)
    case.write_text(case_of(shot, setting, options, grown, draw))
    begin = time.monotonic()
    with open(folder / "log.txt", "w") as log:
        command = [*options.before, options.program, "run", case, "--out", folder / "run",
                   "--overwrite"]
        try:
            code = subprocess.run(command, stdout=log, stderr=subprocess.STDOUT,
                                  timeout=options.limit).returncode
        except subprocess.TimeoutExpired:
            code = None
    line["seconds"] = f"{time.monotonic() - begin:.0f}"
    if code != 0:
        return line | {"verdict": "too long" if code is None else "failed"}
    results = tomllib.loads((folder / "run/results.toml").read_text())
    wall, told = results["shield_wall"], (folder / "log.txt").read_text()
    with open(folder / "run/series.csv") as file:
        unexplained = max(abs(float(row["unexplained"])) for row in csv.DictReader(file))
    struck = 0.5 * ball_of(shot) * (1000 * shot.speed)**2
    return line | {
        "verdict": wall["verdict"], "margin": f"{wall['margin']:.4g}",
        "margin_before": f"{wall['margins'][-2]:.4g}" if len(wall["margins"]) > 1 else "",
        "still_coming": f"{wall['still_coming']:.3g}", "opening_at_edge": wall["opening_at_edge"],
        "hole_mm": f"{1e3 * wall['hole']:.4g}", "spall_mg": f"{1e6 * wall['spall_mass']:.4g}",
        "ball_mg": f"{1e6 * mass_of_ball(told):.4g}",
        "largest_met_j": f"{wall['largest_met']:.3g}",
        "met_size_mm": in_a_cell(1e3 * x for x in wall["largest_met_size"]),
        "met_rotation": in_a_cell(wall["largest_met_rotation"]),
        "met_velocity_m_s": in_a_cell(wall["largest_met_velocity"]),
        "largest_passed_j": f"{wall['largest_passed']:.3g}",
        "energy_unexplained": f"{unexplained / struck:.2e}",
        "bodies": re.search(r"(\d+) bodies, ", told)[1],
        "commit": results["provenance"]["commit"]}


def known(path):
    return list(csv.DictReader(path.open())) if path.exists() else []


def keep(line, columns, path):
    """Adds a line to a file that is written anew as a whole, so that a stop leaves the old or the
    new."""
    rows = known(path) + [{key: str(line.get(key, "")) for key in columns}]
    with tempfile.NamedTemporaryFile("w", dir=path.parent, delete=False, newline="") as file:
        writer = csv.DictWriter(file, columns, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    os.chmod(file.name, 0o644)
    os.replace(file.name, path)


def ask_for_setting(parser):
    """Adds the options that tell runs of the same shot apart."""
    for key, told in (("across", "bodies across the ball"),
                      ("wall_across", "bodies of the wall on the ball's diameter, at least"),
                      ("seed", "of the crystals' orientations"),
                      ("end", "of the duration that the rule has"),
                      ("spread", "of the cloud, over the stand-off, that the wall covers")):
        value = getattr(FINE, key)
        parser.add_argument("--" + key.replace("_", "-"), type=type(value), default=value,
                            help=told)


def ask_for_runs(parser, out):
    """Adds the options that tell which runs are made, when and how; results go below `out`."""
    parser.add_argument("--rows", type=int, nargs="+", metavar="ROW",
                        help="these alone, as for another number across")
    parser.add_argument("--until", metavar="HH:MM", help="nothing is begun later today")
    parser.add_argument("--jobs", type=int, default=1, help="runs at a time, one rank each")
    parser.add_argument("--program", default=ROOT / "build/release/spall")
    parser.add_argument("--before", default="", help='put before the program, such as "nice -n 5"')
    parser.add_argument("--out", type=Path, default=out)


def end_of(until):
    """s since 1970, of a time of today, HH:MM, or never."""
    if not until:
        return math.inf
    hour, minute = map(int, until.split(":"))
    return datetime.datetime.now().replace(hour=hour, minute=minute, second=0).timestamp()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    ask_for_setting(parser)
    ask_for_runs(parser, ROOT / "out/shields")
    parser.add_argument("--most", type=int, default=math.inf, help="shots that are run now")
    parser.add_argument("--limit", type=float, default=3600,
                        help="s that a run may take; at --until it is given up")
    parser.add_argument("--plan", action="store_true", help="list the shots, run nothing")
    parser.add_argument("--trial", type=int, nargs="+", default=[], metavar="ROW",
                        help="shots outside of the rule")
    options = parser.parse_args()
    options.before = options.before.split()
    shots = read_shots()
    wanted = chosen(shots) + beside(shots)
    if options.plan:
        for shot in wanted:
            setting = set_up(shot, options)
            print(f"{class_of(rule(shot))} {shot.row:4} {shot.source:20} {shot.name:18} "
                  f"{setting.bodies:8.0f} bodies, {setting.cost:8.2g} body-steps at most")
        cost = sum(set_up(shot, options).cost for shot in wanted)
        print(f"{len(wanted)} shots, {cost:.3g} body-steps")
        return
    if options.trial:
        counted = {shot.row for shot in wanted}
        for row in options.trial:
            if row in counted:
                sys.exit(f"shot {row} counts: the machinery is tried on others")
            print(run(options, shots[row - 1]), flush=True)
        return
    end = end_of(options.until)
    done = {int(line["row"]) for line in known(RESULTS) if is_of(line, options)}
    left = [shot for shot in wanted if shot.row not in done]
    if options.rows:
        left = [shot for shot in left if shot.row in options.rows]
    left = left[:min(len(left), options.most)]
    print(f"{len(wanted)} shots, {len(wanted) - len(left)} of them done or not asked for")
    lock, begun = threading.Lock(), iter(left)

    def work():
        for shot in begun:
            allowed = min(options.limit, end - time.time())
            if allowed <= 0:
                return
            limited = argparse.Namespace(**{**vars(options), "limit": allowed})
            line = run(limited, shot)
            if line["verdict"] == "too long" and time.time() >= end:
                return  # given up for the clock's sake: it is run again
            with lock:
                keep(line, COLUMNS, RESULTS)
            print(*line.values(), flush=True)

    workers = [threading.Thread(target=work) for _ in range(options.jobs)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()


if __name__ == "__main__":
    os.environ.setdefault("OMPI_ALLOW_RUN_AS_ROOT", "1")
    os.environ.setdefault("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1")
    main()
