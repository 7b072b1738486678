"""Shoots balls through bumpers, and pieces at walls, and puts what becomes of them beside what is
known. Writes the tables of README.md.

    /usr/bin/python3 cases/breakup/measure.py onset pieces constants landing shock wall forms \\
        shields

SPDX-License-Identifier: BSD-3-Clause
"""
import argparse
import re
import sys
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

HERE = Path(__file__).parent
sys.path += [str(HERE.parent), str(HERE.parent.parent / "bench")]
from cour_palais import crater_depth  # noqa: E402
from euler import peaks  # noqa: E402
from program import PROGRAM, ROOT, spall  # noqa: E402
from readme import replace_section  # noqa: E402
from remnants import clump_names, commits, results  # noqa: E402

ACROSS = 12  # bodies, as of the shields' balls
BUMPER_LAYERS, BUMPER_WIDTH = 2, 3  # at least; in ball diameters
FLIGHT = 9  # ball diameters at its speed: after 3 most of it still hangs together at 4 km/s
GAP = 0.35  # spacings between the surfaces of neighbours: bodies of a piece are nearer
SEEN = 0.01  # of the ball: lighter pieces are not counted


@dataclass(frozen=True)
class Shot:
    """Of balls of 9.53 mm of 2017-T4 at bumpers of 6061-T6."""
    name: str
    bumper: float  # of the ball's diameter
    speed: float  # km/s
    breaks: bool  # the shell that spall has parted from the ball's rear is ruptured


# Piekutowski, Int. J. Impact Engng 29 (2003) 563, read off the figure that Reimerdes, Noelke &
# Schaefer, Int. J. Impact Engng 33 (2006) 645 show of it: speeds are good to 0.1 km/s.
SHOTS = [Shot("4-1715", 0.026, 4.6, False), Shot("4-1428", 0.049, 3.77, False),
         Shot("4-1633", 0.062, 3.65, True), Shot("4-1632", 0.084, 3.4, True),
         Shot("4-1722", 0.13, 2.5, False), Shot("4-1718", 0.233, 2.0, False),
         Shot("4-1720", 0.233, 2.4, False), Shot("4-1719", 0.233, 2.7, True),
         Shot("4-1721", 0.5, 2.25, False)]
DIAMETER = 9.53e-3  # m
SMALL = 3.18e-3  # m, of most balls of the shields
SMALL_BUMPER, SMALL_SPEED = 0.25, 4.2  # of its diameter; km/s
NO_STRAIN = [f"materials.ball.solid.johnson_cook_d{k}=0" for k in range(1, 6)]  # never fails by it
CONSTANTS_SPEED = 5.5  # km/s, where walls ask for balls heavier than the pieces
MELTING = 775  # K, of 2024-T351
# Of the largest pieces behind balls of these speeds (km/s): share of the ball, speed along the axis
# (km/s), and a wall that such shots have (mm). From 6.4 km/s on by `landing`, below that of rows
# 590, 596 and 536 of the shields, 18 across.
LARGEST = ((3.1, 0.239, 2.49, 3.18), (3.0, 0.265, 2.40, 2.70), (4.3, 0.0198, 3.39, 2.19),
           (6.4, 0.0057, 4.81, 1.40), (6.4, 0.0057, 4.81, 1.59), (7.2, 0.0030, 4.62, 1.40))
PIECE = 0.9e-3  # m, diameter of a ball as heavy as a piece that hits a wall
PIECE_SPEED = 4  # km/s
HARDNESS, DENSITIES = 95, 2.80 / 2.71  # Brinell's, of 6061-T6; of 2017-T4 over that
# Of the finest wall under such a piece, which costs 30 times as much otherwise: m, s.
NARROW_WIDTH, NARROW_LASTS = 7e-3, 8e-6
FINE_ACROSS = 7.5  # bodies of such a piece
# Forms of two largest pieces at 5.5 km/s, whose widths are made those of a piece as heavy as PIECE:
# across, across, and along the flight.
FORMS = (("as a ball", (1, 1, 1)),
         ("flat", (1.13, 0.85, 0.49)), ("end on", (0.49, 0.85, 1.13)),
         ("flat", (1.89, 0.81, 0.38)), ("on edge", (0.38, 1.89, 0.81)),
         ("end on", (0.38, 0.81, 1.89)))
FORMS_WALL, FORMS_BODIES = 2.4e-3, 0.12e-3  # m
# Of the block in which the shock below it is followed, for so long: diameters of the piece; s.
BLOCK_WIDTH, BLOCK_DEPTH, SHOCK_LASTS, SHOCK_FRAMES = 2.7, 1.6, 0.25e-6, 50
SHOCK_DEPTHS, NEAR_AXIS, NEAR_DEPTH = (0.5, 0.75, 1, 1.25), 0.13, 0.06  # diameters
CELLS = 72  # across the piece, by euler.py


def run(options, case, folder, changes):
    folder = options.out / folder
    spall("run", HERE / case, "--out", folder, "--overwrite", changes=changes,
          program=options.program, before=options.before.split())
    return folder


def through_a_bumper(options, folder, d, bumper, speed, across=ACROSS, more=()):
    """d in m, the bumper in balls, km/s."""
    thick, ball = bumper * d, d / across
    spacing, duration = min(ball, thick / BUMPER_LAYERS), FLIGHT * d / (1e3 * speed)
    return run(options, "case.toml", folder, [
        f"groups.bumper.volume.diameter={BUMPER_WIDTH * d}",
        f"groups.bumper.volume.height={thick}", f"groups.bumper.volume.center=[0,0,{-thick / 2}]",
        f"groups.bumper.packing.diameter={spacing}", f"groups.ball.volume.diameter={d}",
        f"groups.ball.volume.center=[0,0,{d / 2 + 1.05 * ball}]",
        f"groups.ball.packing.diameter={ball}", f"groups.ball.velocity=[0,0,{-1e3 * speed}]",
        f"phases.impact.step={duration / 200}", f"phases.impact.duration={duration}",
        f"output.series_every={duration / 10}", f"output.snapshot_every={duration / 5}", *more])


def pieces(folder, count=4, below=np.inf):
    """Of what the ball has become: the share of its bodies that have failed, and of the largest
    pieces that hang together their shares of its mass, and their velocities (m/s); 0 where there
    are fewer. Bodies that are not colder than `below` (K) count as failed."""
    with h5py.File(folder / "trajectory.h5") as file:
        bodies = file["particles/all"]
        ball = bodies["group"][:] == 1
        whole = ((bodies["damage/value"][-1][ball] < 1)
                 & (bodies["temperature/value"][-1][ball] < below))
        position, velocity = (bodies[f"{field}/value"][-1][ball][whole]
                              for field in ("position", "velocity"))
        radius = bodies["radius"][:][ball]
    name = clump_names(position, radius[whole], 2 * GAP * radius[0])
    sizes = np.append(np.bincount(name), [0] * count)
    largest = np.argsort(-sizes, kind="stable")[:count]
    motions = [velocity[name == piece].mean(axis=0) if sizes[piece] else np.zeros(3)
               for piece in largest]
    return 1 - whole.mean(), sizes[largest] / len(whole), np.array(motions)


def bodies_of(share, across):
    """In a piece with this share of a ball."""
    return share * np.pi / 6 * np.sqrt(2) * across**3


def molten(folder):
    """The share of the ball's bodies that are hotter in the end than the melting point of the
    ball's metal as it is."""
    with h5py.File(folder / "trajectory.h5") as file:
        bodies = file["particles/all"]
        return (bodies["temperature/value"][-1][bodies["group"][:] == 1] >= MELTING).mean()


def onset(options):
    text = ["| shot | bumper, diameters | km/s | measured | Spall | largest piece | next | failed "
            "|\n|---|--:|--:|---|---|--:|--:|--:|"]
    folders = []
    for shot in SHOTS:
        folder = through_a_bumper(options, f"onset-{shot.name}", DIAMETER, shot.bumper, shot.speed)
        failed, shares, _ = pieces(folder)
        called = "broken" if shares[1] > SEEN else "in one piece"
        text.append(f"| {shot.name} | {shot.bumper:g} | {shot.speed:g} "
                    f"| {'broken' if shot.breaks else 'in one piece'} | {called} "
                    f"| {shares[0]:.3f} | {shares[1]:.3f} | {failed:.2f} |")
        folders.append(folder)
    return text, folders


def finer(options):
    text = ["| fails by strain | across | failed | largest pieces, of the ball "
            "| bodies in the largest |\n|---|--:|--:|---|--:|"]
    folders = []
    for fails, more in (("yes", ()), ("no", NO_STRAIN)):
        for across in (12, 18, 24):
            folder = through_a_bumper(options, f"pieces-{fails}-{across}", SMALL, SMALL_BUMPER,
                                      SMALL_SPEED, across, more)
            failed, shares, _ = pieces(folder)
            text.append(f"| {fails} | {across} | {failed:.2f} "
                        f"| {', '.join(f'{share:.3f}' for share in shares)} "
                        f"| {bodies_of(shares[0], across):.0f} |")
            folders.append(folder)
    return text, folders


def constants(options):
    """Of what the pieces of one ball depend."""
    text = ["| ball | across | failed | hotter than melting needs | largest pieces, of the ball "
            "| colder than that, the largest |\n|---|--:|--:|--:|---|--:|"]
    folders = []
    solid = "materials.ball.solid."
    hot, melts = solid + "johnson_cook_d5=1.6", solid + "melting_point=1220"
    for number, (name, *changes) in enumerate((
            ("as it is",), ("fracture energy twice as large", solid + "fracture_energy=28.2e3"),
            ("spall strength 1.0 GPa", solid + "spall_strength=1e9"),
            ("spall strength 2.2 GPa", solid + "spall_strength=2.2e9"),
            ("does not fail by strain", *NO_STRAIN),
            ("the hotter, the more strain it bears: D5 = 1.6", hot),
            ("melts only with the heat of fusion: at 1220 K", melts),
            ("the last two", hot, melts),
            ("melts so, and does not fail by strain", melts, *NO_STRAIN))):
        for across in (18, 24):
            folder = through_a_bumper(
                options, f"constants-{number}-{across}", SMALL, SMALL_BUMPER, CONSTANTS_SPEED,
                across, changes)
            failed, shares, _ = pieces(folder)
            cold = pieces(folder, 1, MELTING)[1][0]
            text.append(f"| {name} | {across} | {failed:.2f} | {molten(folder):.2f} "
                        f"| {', '.join(f'{share:.4f}' for share in shares)} | {cold:.4f} |")
            folders.append(folder)
    return text, folders


def landing(options):
    text = ["| km/s | across | failed | largest pieces, of the ball | their speed, km/s "
            "| sideways, of that, of the ten largest |\n|--:|--:|--:|---|---|---|"]
    folders = []
    for speed, across in ((4.2, 24), (5.5, 24), (6.4, 12), (6.4, 18), (6.4, 24), (7.2, 24)):
        folder = through_a_bumper(options, f"landing-{speed}-{across}", SMALL, SMALL_BUMPER, speed,
                                  across)
        failed, shares, motions = pieces(folder, 10)
        motions = motions[shares > 0]
        along = -motions[:, 2]
        sideways = np.hypot(motions[:, 0], motions[:, 1]) / along
        text.append(f"| {speed} | {across} | {failed:.3f} "
                    f"| {', '.join(f'{share:.4f}' for share in shares[:4])} "
                    f"| {', '.join(f'{one / 1e3:.2f}' for one in along[:4])} "
                    f"| {sideways.min():.2f} to {sideways.max():.2f} |")
        folders.append(folder)
    return text, folders


def toml(numbers):
    return f"[{', '.join(f'{x:.9g}' for x in numbers)}]"


def turned_by(vector):
    """The matrix of a rotation vector (rad)."""
    angle = np.linalg.norm(vector)
    x, y, z = np.asarray(vector) / angle if angle else np.zeros(3)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def laid_piece(size, rotation, of_piece, spacing):
    """A piece of bodies of one size before a wall of bodies of another. `size`: full widths of an
    ellipsoid. m, rad."""
    half = np.linalg.norm(turned_by(rotation)[2] * size) / 2
    clear = half + 1.05 * max(of_piece, spacing)
    return [f"groups.piece.volume.size={toml(size)}", f"groups.piece.packing.diameter={of_piece}",
            f"groups.piece.volume.rotation={toml(rotation)}",
            f"groups.piece.volume.center=[0,0,{clear}]"]


def grown_by(options, size, spacing, rotation, more):
    """Times which the piece and its spacing are as large, for its mass: a lattice has its own
    number of sites in an ellipsoid."""
    wide = max(size)
    told = spall("check", HERE / "wall.toml", program=options.program, changes=[
        *laid_piece(size, rotation, spacing, spacing),
        *(one for one in more if one.startswith("seed")),
        # As fine a wall, and a small one: through a coarse one bodies of the piece would slip.
        f"groups.wall.packing.diameter={spacing}", f"groups.wall.volume.diameter={3 * wide}",
        f"groups.wall.volume.height={wide}", f"groups.wall.volume.center=[0,0,{-wide / 2}]"])
    filled = float(re.search(r"^  piece .* (\S+)$", told, re.M)[1])
    return (np.pi / np.sqrt(18) / filled)**(1 / 3)  # spheres of fcc fill pi / sqrt(18)


def shoot_form(options, name, size, velocity, thick, spacing, of_piece, rotation=(0, 0, 0),
               more=()):
    """A piece of this form, an ellipsoid that is turned, hits a wall. m, m/s, rad."""
    grown = grown_by(options, size, of_piece, rotation, more)
    return run(options, "wall.toml", name, [
        f"groups.wall.volume.height={thick}", f"groups.wall.volume.center=[0,0,{-thick / 2}]",
        f"groups.wall.packing.diameter={spacing}",
        *laid_piece([grown * one for one in size], rotation, grown * of_piece, spacing),
        f"groups.piece.velocity={toml(velocity)}", *more])


def shoot_piece(options, name, piece, speed, thick, spacing, of_piece, more=()):
    """A piece as heavy as a ball of `piece` hits a wall at `speed`. m, m/s."""
    return shoot_form(options, name, [piece] * 3, [0, 0, -speed], thick, spacing, of_piece,
                      more=more)


def for_a_time(lasts, frames):
    return [f"phases.impact.duration={lasts}", f"output.series_every={lasts / frames}",
            f"output.snapshot_every={lasts / frames}"]


def narrow(piece, speed, width=0, lasts=0):
    """Of a wall and its run as large as a piece needs, or as these are. m, m/s, s."""
    size = piece / PIECE
    return [f"groups.wall.volume.diameter={max(width, size * NARROW_WIDTH)}",
            *for_a_time(max(lasts, size * NARROW_LASTS * 1e3 * PIECE_SPEED / speed), 10)]


def hit_wall(options, name, piece, speed, thick, spacing, of_piece):
    """As `shoot_piece`, but in mm and km/s; fine walls are narrow, and their runs short."""
    piece, speed, fine = 1e-3 * piece, 1e3 * speed, spacing < 0.2
    return shoot_piece(options, name, piece, speed, 1e-3 * thick, 1e-3 * spacing, 1e-3 * of_piece,
                       narrow(piece, speed) if fine else ())


def shock_below_piece(options, across):
    """The peak pressures (Pa) at SHOCK_DEPTHS, each the mean of its bodies' own; and the run."""
    spacing = PIECE / across
    folder = shoot_piece(options, f"shock-{across}", PIECE, 1e3 * PIECE_SPEED, BLOCK_DEPTH * PIECE,
                         spacing, spacing, [
                             f"groups.wall.volume.diameter={BLOCK_WIDTH * PIECE}",
                             f"phases.impact.step={SHOCK_LASTS / SHOCK_FRAMES}",
                             *for_a_time(SHOCK_LASTS, SHOCK_FRAMES)])
    with h5py.File(folder / "trajectory.h5") as file:
        bodies = file["particles/all"]
        block = bodies["group"][:] == 0
        place = bodies["position/value"][0][block] / PIECE
        peak = bodies["pressure/value"][:][:, block].max(axis=0)
    axis = np.hypot(place[:, 0], place[:, 1]) < NEAR_AXIS
    return [peak[axis & (abs(place[:, 2] + depth) < NEAR_DEPTH)].mean()
            for depth in SHOCK_DEPTHS], folder


def shock(options):
    columns = [peaks(PIECE, 1e3 * PIECE_SPEED, CELLS, SHOCK_DEPTHS)]
    folders, sizes = [], (7.5, 12, 18)
    for across in sizes:
        peak, folder = shock_below_piece(options, across)
        columns.append(peak)
        folders.append(folder)
    heads = [f"{across:g} across" for across in sizes]
    text = [f"| depth, diameters | Euler's equations | {' | '.join(heads)} |",
            "|--:|--:|--:|--:|--:|"]
    for share, *row in zip(SHOCK_DEPTHS, *columns):
        text.append(f"| {share:g} | {' | '.join(f'{one / 1e9:.1f}' for one in row)} |")
    return text, folders


def told_of_wall(folder):
    told = results(folder)["shield_wall"]
    return f"{told['verdict']} | {told['margin']:.2f} | {1e3 * told['hole']:.2f}"


def wall(options):
    text = ["| wall, mm | its bodies, mm | the piece's, mm | verdict | margin | hole, mm |",
            "|--:|--:|--:|---|--:|--:|"]
    folders = []
    for thick in (1.6, 2.0, 2.4):
        for spacing, of_piece in ((0.53, 0.265), (0.265, 0.265), (0.12, 0.12)):
            folder = hit_wall(options, f"wall-{thick}-{spacing}", 1e3 * PIECE, PIECE_SPEED, thick,
                              spacing, of_piece)
            text.append(f"| {thick} | {spacing} | {of_piece} | {told_of_wall(folder)} |")
            folders.append(folder)
    return text, folders


def forms(options):
    text = ["| form, mm | lies | verdict | margin | hole, mm |", "|---|---|---|--:|--:|"]
    folders = []
    for name, size in FORMS:
        size = np.array(size) * 1e-3
        size *= PIECE / size.prod()**(1 / 3)
        told = " by ".join(f"{1e3 * one:.2f}" for one in size)
        folder = shoot_form(options, f"form-{name.replace(' ', '-')}-{told[:4]}", size,
                            [0, 0, -1e3 * PIECE_SPEED], FORMS_WALL, FORMS_BODIES, FORMS_BODIES,
                            more=narrow(PIECE, 1e3 * PIECE_SPEED))
        text.append(f"| {told} | {name} | {told_of_wall(folder)} |")
        folders.append(folder)
    return text, folders


def shields(options):
    text = ["| ball, km/s | piece, mm | its km/s | wall, mm | perforated up to, mm "
            "| spall up to, mm | bodies, mm | verdict | margin | hole, mm |",
            "|--:|--:|--:|--:|--:|--:|--:|---|--:|--:|"]
    folders = []
    for ball, share, speed, thick in LARGEST:
        piece = 1e3 * SMALL * share**(1 / 3)
        crater = crater_depth(piece, speed, HARDNESS, DENSITIES)
        for spacing, of_piece in ((0.53, 0.177), (piece / FINE_ACROSS,) * 2):
            folder = hit_wall(options, f"shields-{ball}-{thick}-{spacing:.3g}", piece, speed, thick,
                              spacing, of_piece)
            text.append(f"| {ball} | {piece:.2f} | {speed} | {thick:.2f} | {1.8 * crater:.2f} "
                        f"| {2.2 * crater:.2f} | {spacing:.2g} | {told_of_wall(folder)} |")
            folders.append(folder)
    return text, folders


TABLES = {"onset": onset, "pieces": finer, "constants": constants, "landing": landing,
          "shock": shock, "wall": wall, "forms": forms, "shields": shields}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("tables", nargs="+", choices=TABLES)
    parser.add_argument("--program", default=PROGRAM)
    parser.add_argument("--before", default="", help='put before the program, such as "nice -n 5"')
    parser.add_argument("--out", type=Path, default=ROOT / "out/breakup")
    options = parser.parse_args()
    for name in options.tables:
        text, folders = TABLES[name](options)
        unexplained = max(results(folder)["conservation"]["energy_unexplained"]
                          for folder in folders)
        text += ["", f"Commits: {commits(folders)}. Energy that no entry explains: at most "
                 f"{100 * unexplained:.2g} % of what was dissipated."]
        print("\n".join(text), flush=True)
        replace_section(HERE / "README.md", name, "\n".join(text))


if __name__ == "__main__":
    main()
