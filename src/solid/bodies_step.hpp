// From the motion of its neighbours to the stress of each body.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "solid/law.hpp"
#include "solid/rows.hpp"
#include "spall/bodies.hpp"

namespace spall {

/// m^3, of each body at rest: its mass at the solid's density; of a held one its cell of fcc.
std::vector<double> rest_volumes(const Bodies& bodies, const std::vector<SolidLaw>& laws);
/// J, of owned bodies.
double elastic_energy(const Bodies& bodies);

/// Brings the density, stress and energy of owned bodies, the rising list `which`, from where
/// bodies were `h` (s) ago to where they are, and tells how they answer. With the sums of
/// `sweep_shapes`, taken with the velocities since then, L = M K^-1 is the gradient against the
/// present places, so
///
///   F = (1 - h L)^-1 is what has deformed the body, and L_mid = L (1 - h L/2)^-1
///
/// the gradient in the middle: stress turns by Hughes and Winget's rotation (Int. J. Numer. Methods
/// Eng. 15 (1980) 1862), and all is of second order in h. Directions in which K has less than a
/// tenth of its largest eigenvalue are not resolved: there is neither strain nor stress.
/// Then the stress returns to the flow stress along its deviator. Tension beyond what is left of
/// the strength, strength (1 - D), opens voids until it is no more than that. The damage D is what
/// voids have been at most, of those at which nothing is borne; or the sum of plastic strain over
/// Johnson and Cook's strain at failure; of a brittle solid, what its cracks have taken the load
/// from (solid/flaws.hpp). At 1 the body bears pressure and friction. The energy grows by
/// the power of the pairs' forces: by that of the new stress over `late` (s), by that of the old
/// one over the rest of h. Returns the heat (J) that bodies gained.
double update_bodies(Bodies& bodies, const std::vector<SolidLaw>& laws,
                     const std::vector<double>& rest_volume, std::span<const Index> which, double h,
                     double late, const ShapeRow* shapes, const MotionRow* rows,
                     ResponseRow* responses);

}  // namespace spall
