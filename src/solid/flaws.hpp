// Cracks that grow from flaws in brittle solids.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "solid/law.hpp"
#include "spall/bodies.hpp"

namespace spall {

/// m/s: cracks grow at 0.4 of the speed of longitudinal waves (Lawn & Wilshaw, Fracture of Brittle
/// Solids (1975), as Benz & Asphaug, Icarus 107 (1994) 98, use it).
double crack_speed(const SolidLaw& law);

/// How many flaws of a body (of this volume at rest, m^3) this tensile strain opens. Flaws of a
/// body are a Poisson process of mean k V eps^m: the thresholds of its flaws are
///
///   eps_n = ((E_1 + ... + E_n) / (k V))^(1/m),   E exponential, drawn from seed, body and n.
///
/// So nothing is kept: any rank draws the same again. Where more than 64 are expected, these are
/// what is returned, with an error of 4 % in the cube root that cracks grow by.
double open_flaws(const SolidLaw& law, BodyId body, double volume, double strain);

/// The tensile strain that opens a flaw in half of the bodies of this spacing (m).
double strain_of_first_flaw(const SolidLaw& law, double spacing);

/// The damage of an owned body `h` (s) on. Its n open flaws are cracks that grow as spheres
/// (Grady & Kipp; Benz & Asphaug, Comput. Phys. Commun. 87 (1995) 253),
///
///   dD^(1/3)/dt = n^(1/3) c_g / R,   4 pi R^3/3 = V,   eps = sigma / E,
///
/// sigma the largest principal stress, here in what is intact, whose deviator is `intact` times the
/// body's: sigma/(1 - D) where it is pulled and cracks are open. What is pressed bears the pressure
/// on all of its volume.
double grown_damage(const SolidLaw& law, const Bodies& bodies, Index row, double volume,
                    double intact, double h);

}  // namespace spall
