// How a body turns that nothing acts on.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "spall/types.hpp"

namespace spall {

/// Where a free body's axes are, and how it turns.
struct Turn {
  Quaternion orientation;  ///< turns its principal axes into the world's
  Vec3 angular_velocity;   ///< rad/s, in the world's frame
};

/// The same after `h` (s), of a body with these principal moments, in any unit. Symmetric turns
/// about one axis after the other (McLachlan 1993; Touma & Wisdom 1994): angular momentum is that
/// of before to round-off; angles and energy are good to second order, and energy does not drift.
Turn turn_freely(const Vec3& inertia, const Turn& from, double h);

/// Turned by a rotation vector (rad, in the world's frame).
Quaternion turned_by(const Vec3& rotation, const Quaternion& orientation);

}  // namespace spall
