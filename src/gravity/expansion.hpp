// The five operations of a fast multipole method, on whole cells; formulas in multipole.hpp.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "gravity/attract.hpp"
#include "gravity/multipole.hpp"

namespace spall {

/// Moments of a leaf from its bodies; `row` has its mass, centre and velocity already. `rates`
/// false leaves the sum of m |v - mean| out.
template <int P>
void measure_bodies(std::span<const Eight> leaf, bool rates, Moments<P>& row);

/// Adds the moments of a part of the cell; `whole` has its mass, centre and velocity already.
template <int P>
void add_moments(Moments<P>& whole, const Moments<P>& part);

/// Adds the field of the cells `far` to that of the cell `target`, whose bodies lie within
/// `radius`. The bound on its rate is worked out only where `rates` are asked for.
template <int P>
void attract_by_far(std::span<const Moments<P>* const> far, const Moments<P>& target, double radius,
                    bool rates, LocalField<P>& field);

/// The field of a cell, seen from the centre of a part of it, `s` away.
template <int P>
LocalField<P> shifted(const LocalField<P>& field, const Vec3& s, double velocity_change);

/// The bodies of a leaf feel the field about its centre, and the bound on its rate if `rates`.
template <int P>
void attract_by_field(const LocalField<P>& field, const Moments<P>& row, bool rates,
                      std::span<Eight> leaf);

}  // namespace spall
