"""Five published ballistic limit equations of double walls, in cm, g, km/s, ksi and degrees, as
they were published.

NNO: Christiansen, Int. J. Impact Engng 14 (1993) 145.
Modified NNO: Christiansen & Kerr, Int. J. Impact Engng 26 (2001) 93.
JSC: Ryan & Christiansen, Acta Astronautica 69 (2011) 245.
Modified JSC: Ryan & Schonberg, Int. J. Impact Engng 187 (2024) 104899.
Reimerdes: Reimerdes, Nölke & Schäfer, Int. J. Impact Engng 33 (2006) 645.
Where papers leave a choice it is that of pyBLOSSUM (https://github.com/shannonjryan/pyBLOSSUM, MIT
licence, commit fe0a7df): 65 degrees is the largest angle; de-rating factors are found together with
the diameter. Its code differs from the papers in three things, in which this follows the papers:
the modified NNO's k_h is 1.35 but for thin bumpers; a ball's mass is pi/6 rho d^3, by which their
constants belong together; and the JSC equations' low regime ends later where the bumper is thin.
SPDX-License-Identifier: BSD-3-Clause
"""
import csv
from collections import Counter
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations
from math import cos, exp, log, pi, radians
from pathlib import Path

SHOTS = Path(__file__).with_name("shots.csv")
STEEPEST = 65  # degrees: beyond that the equations have the value that they have there
STEEPEST_CHEAP = 45  # degrees, of shots that are cheap for a particle code
HYPERVELOCITY = 7.0  # km/s, along the normal: from here on the ball is taken to melt
SWAPPED = "AFML-TR-70-135"  # of this report the table has holes where walls held: see README.md


@dataclass(frozen=True)
class Shot:
    """A row of shots.csv: lengths in cm, densities in g/cm^3, speed in km/s, angle from the normal
    in degrees."""
    row: int  # of the file, counted from 1 without its two heads: no other name is a shot's alone
    source: str
    name: str
    metals: tuple  # of ball, bumper, wall
    density: tuple
    diameter: float
    angle: float
    speed: float
    bumper: float
    standoff: float
    wall: float
    strength: float  # of the wall at yield, ksi
    perforated: bool  # a hole, or spall that has left the wall's back


def read_shots(path=SHOTS):
    with open(path) as file:
        rows = list(csv.DictReader(file))[1:]  # the second head tells units
    parts = ("proj", "bumper", "wall")
    return [Shot(k, row["source"], row["shotID"].strip(),
                 tuple(row[f"{part}_mat"] for part in parts),
                 tuple(float(row[f"{part}_density"]) for part in parts),
                 *(float(row[key]) for key in ("proj_diam", "angle", "velocity", "bumper_thick",
                                               "standoff", "wall_thick", "wall_yield")),
                 row["perforated_class"] == "1")
            for k, row in enumerate(rows, 1)]


def is_cheap(shot):
    """What a particle code can do with few bodies: the class that is looked at apart."""
    d = shot.diameter
    return (shot.speed >= 3 and shot.wall < 1.5 * d and shot.standoff < 40 * d
            and shot.bumper < 0.6 * d and shot.angle <= STEEPEST_CHEAP)


def cosine(shot):
    return cos(radians(min(shot.angle, STEEPEST)))


def joined(shot, low, high, end_of_low, start_of_high):
    """Critical diameter (cm): one law up to a speed (km/s), another from a second speed on, a line
    between them."""
    v = shot.speed
    if v <= end_of_low:
        return low(v)
    if v >= start_of_high:
        return high(v)
    first, last = low(end_of_low), high(start_of_high)
    return first + (last - first) * (v - end_of_low) / (start_of_high - end_of_low)


def cour_palais_low(shot, v):
    """Low speeds: one thick wall of both plates, after Cour-Palais."""
    plates = shot.wall * (shot.strength / 40) ** 0.5 + shot.bumper
    return (plates / (0.6 * cosine(shot) ** (5 / 3) * shot.density[0] ** 0.5
                      * v ** (2 / 3))) ** (18 / 19)


def christiansen_high(shot, v):
    """High speeds: a cloud that has melted, where the bumper is thick enough."""
    ball, bumper, _ = shot.density
    return (3.918 * shot.wall ** (2 / 3) * shot.standoff ** (1 / 3)
            * (shot.strength / 70) ** (1 / 3)
            / (ball ** (1 / 3) * bumper ** (1 / 9) * (v * cosine(shot)) ** (2 / 3)))


def nno(shot):
    c = cosine(shot)
    return joined(shot, partial(cour_palais_low, shot), partial(christiansen_high, shot),
                  3 / c, HYPERVELOCITY / c)


def modified_nno(shot):
    c = cosine(shot)
    ball, bumper, wall = shot.density
    thin = shot.bumper / (shot.wall ** (2 / 3) * shot.standoff ** (1 / 3))
    factor = 7.451 * thin + 0.411 if thin < 0.126 else 1.35

    def low(v):
        plates = shot.wall * (shot.strength / 40) ** 0.5 + 0.37 * shot.bumper * bumper
        return 1.9 * plates / (c ** (11 / 6) * ball ** 0.5 * v ** (2 / 3))

    def high(v):
        return (factor * (shot.wall * wall) ** (2 / 3) * shot.standoff ** 0.5
                * (shot.strength / 70) ** (1 / 3)
                / (ball ** (1 / 3) * bumper ** (1 / 9) * (v * c) ** (2 / 3)))

    return joined(shot, low, high, 3 / c ** 1.5, HYPERVELOCITY / c)


def root(rises, guess):
    """Where a function of a positive number passes from below 0 to above, within a factor of 1000
    of a guess."""
    low, high = log(guess / 1000), log(guess * 1000)
    for _ in range(60):
        middle = (low + high) / 2
        if rises(exp(middle)) < 0:
            low = middle
        else:
            high = middle
    return exp(high)


def derated(shot, v, factor):
    """The diameter (cm) that is that of a thick bumper divided by the 2/3 power of its own
    de-rating factor."""
    thick = christiansen_high(shot, v)
    return root(lambda d: d - thick * factor(d) ** (-2 / 3), thick)


def thin_bumper(ratio, thickness):
    """De-rating factor F2*: 1 from the critical thickness on, and the ratio of the walls needed
    without a bumper."""
    return 1.0 if thickness >= 1 else ratio - (ratio - 1) * thickness * (2 - thickness)


def mass(d, density):
    """Of a ball (g)."""
    return pi / 6 * d ** 3 * density


def onset(shot):
    """km/s along the normal, from which on the ball breaks: of the critical ball at that speed."""
    def broken(v):
        thickness = shot.bumper / cour_palais_low(shot, v / cosine(shot))
        return 2.6 if thickness >= 0.16 else max(2.6, 1.436 * thickness ** (-1 / 3))

    return min(root(lambda v: v - broken(v), 3.0), HYPERVELOCITY)


def jsc(shot, modified=False):
    c = cosine(shot)
    ball, bumper, _ = shot.density

    def factor(d, v):
        none = (0.6 * d ** (19 / 18) * c ** (5 / 3) * ball ** 0.5 * v ** (2 / 3)
                / (shot.strength / 40) ** 0.5)
        enough = (0.16 * d ** 0.5 * (ball * bumper) ** (1 / 6) * mass(d, ball) ** (1 / 3) * v * c
                  * (70 / shot.strength / shot.standoff) ** 0.5)
        far = shot.standoff / d
        critical = 0.20 if far >= 30 else 0.25
        if modified:
            critical = (0.25 - 0.05 * min(1, max(0, (far - 15) / 15))) * ball / bumper
        return thin_bumper(none / enough, shot.bumper / d / critical)

    def high(v):
        return derated(shot, v, lambda d: factor(d, v if modified else HYPERVELOCITY / c))

    return joined(shot, partial(cour_palais_low, shot), high, onset(shot) / c, HYPERVELOCITY / c)


def reimerdes(shot):
    c = cosine(shot)
    ball, bumper, _ = shot.density
    k, k_infinity = 1.8, 0.42  # of a plate that is just perforated, of a thick target

    def low(v):
        plates = shot.wall / k + shot.bumper
        return (plates / (0.796 * k_infinity * ball ** 0.518 * (v * c) ** (2 / 3))) ** (18 / 19)

    def factor(d):
        v = HYPERVELOCITY  # along the normal
        m = mass(d, ball)
        none = k * k_infinity * m ** 0.352 * ball ** (1 / 6) * v ** (2 / 3)
        enough = (0.178 * m ** 0.5 * bumper ** (1 / 6) * v
                  * (70 / shot.strength / shot.standoff) ** 0.5)
        return thin_bumper(none / enough,
                           shot.bumper / d / (0.20 if shot.standoff / d >= 30 else 0.25))

    # The ball breaks from 1.853 + 0.397 (t/d)^-0.565 km/s on, of the critical ball at that speed.
    above = root(lambda x: shot.bumper * (x / 0.397) ** (1 / 0.565) - low(1.853 + x), 1.0)
    return joined(shot, low, lambda v: derated(shot, v, factor), (1.853 + above) / c,
                  HYPERVELOCITY / c)


EQUATIONS = {"NNO": nno, "modified NNO": modified_nno, "JSC": jsc,
             "modified JSC": partial(jsc, modified=True), "Reimerdes": reimerdes}


def is_right(shot, equation):
    """Whether the equation calls the shot as the laboratory saw it."""
    return (shot.diameter > EQUATIONS[equation](shot)) == shot.perforated


def mended(shots):
    """The same with the ends of SWAPPED as its walls' thickness tells them."""
    return [replace(shot, perforated=not shot.perforated) if shot.source == SWAPPED else shot
            for shot in shots]


def close(one, other, names, within):
    return all(abs(a - b) <= within * max(a, b)
               for a, b in ((getattr(one, name), getattr(other, name)) for name in names))


def alike(shots, within=0.03):
    """Pairs of shots of the same metals that differ by no more than this in each number."""
    names = ("diameter", "angle", "speed", "bumper", "standoff", "wall")
    return [(one, other) for one, other in combinations(shots, 2)
            if one.metals == other.metals and close(one, other, names, within)]


def by_thickness(shots, within=0.02):
    """Of pairs of a report that differ in the wall's thickness and end differently, but are alike
    within this in all else: {report: (in how many the thinner wall failed, the thicker one)}."""
    names = ("diameter", "angle", "speed", "bumper", "standoff")
    thinner, thicker = Counter(), Counter()
    for one, other in combinations(shots, 2):
        if (one.source, one.metals) != (other.source, other.metals) or \
                one.perforated == other.perforated or not close(one, other, names, within) or \
                close(one, other, ("wall",), within / 2):
            continue
        failed, held = (one, other) if one.perforated else (other, one)
        (thinner if failed.wall < held.wall else thicker)[one.source] += 1
    return {source: (thinner[source], thicker[source]) for source in sorted(thinner | thicker)}


def main():
    told = read_shots()
    for labels, shots in (("as the table has them", told), (f"{SWAPPED} mended", mended(told))):
        for name, some in (("all", shots), ("cheap", [shot for shot in shots if is_cheap(shot)])):
            print(f"{name}, {labels}: {len(some)} shots, "
                  f"{sum(shot.perforated for shot in some)} of them perforated")
            for equation in EQUATIONS:
                right = sum(is_right(shot, equation) for shot in some)
                print(f"  {equation:14} {right:4} right, {100 * right / len(some):.1f} %")
            pairs = alike(some)
            differ = sum(one.perforated != other.perforated for one, other in pairs)
            print(f"  of {len(pairs)} pairs that are alike within 3 % {differ} end differently")
    print("Pairs that differ in the wall's thickness alone: the thinner wall failed, the thicker")
    for source, counts in by_thickness(told).items():
        print(f"  {source:18} {counts[0]:3} {counts[1]:3}")


if __name__ == "__main__":
    main()
