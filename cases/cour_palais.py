# How deep a crater is by Cour-Palais's formula.
# SPDX-License-Identifier: BSD-3-Clause
SOUND = 5.1  # km/s, of aluminium


def crater_depth(diameter, speed, hardness, densities):
    """mm, in a thick block of aluminium of this hardness (Brinell) that a ball (mm) of `densities`
    times its density hits at `speed` (km/s). Cour-Palais, Int. J. Impact Engng 5 (1987) 221, as
    NASA/TM-2009-214785 has it. Craters are nearly hemispherical there."""
    return 10 * 5.24 * (diameter / 10)**(19 / 18) * hardness**-0.25 * densities**0.5 * (
        speed / SOUND)**(2 / 3)
