"""The largest piece that met a wall, as it was and as a ball, and the wall that a formula asks for
behind that.

SPDX-License-Identifier: BSD-3-Clause
"""
import math
import sys
from dataclasses import dataclass
from pathlib import Path

from equations import cosine
from run import ball_of

sys.path.append(str(Path(__file__).parent.parent))
from cour_palais import crater_depth  # noqa: E402

HARDNESS = {"AA6061-T6": 95, "AA6061-T651": 95, "AA2024-T3": 120}  # Brinell's, ASM Handbook 2
# Of a crater in a thick block: thinner walls lose spall (NASA/TM-2009-214785).
HOLDS = 2.2


@dataclass(frozen=True)
class Form:
    """An ellipsoid as heavy as the piece and of its form, as it flew at the wall."""
    size: list  # mm, full widths
    rotation: list  # rad, the vector that turns it from the axes
    velocity: list  # km/s

    @property
    def diameter(self):
        """mm, of a ball as heavy."""
        return math.prod(self.size)**(1 / 3)


def form_of(line):
    """Of a line of results.csv; none where no piece was seen to fly at the wall alone, or by runs
    that did not tell it."""
    size, rotation, velocity = ([float(x) for x in line[key].split()] for key in (
        "met_size_mm", "met_rotation", "met_velocity_m_s"))
    if not size or math.isnan(size[0]):
        return None
    return Form(size, rotation, [x / 1e3 for x in velocity])


@dataclass(frozen=True)
class Piece:
    diameter: float  # mm
    speed: float  # km/s, along the wall's normal
    needs: float  # mm, the thickness from which on a wall holds, by the formula


def largest_piece(shot, energy):
    """As a ball of the shot's own ball's metal, which has this energy (J) along the normal at the
    ball's speed along it. Pieces are slower: for one half as fast walls were 3 % thicker."""
    speed = shot.speed * cosine(shot)
    of_ball = ball_of(shot) / 2 * (1e3 * speed)**2  # J: energies are as masses, at one speed
    diameter = 10 * shot.diameter * (energy / of_ball)**(1 / 3)
    ball, _, wall = shot.density
    crater = crater_depth(diameter, speed, HARDNESS[shot.metals[2]], ball / wall)
    return Piece(diameter, speed, HOLDS * crater)
