// Self-gravity: the field of all bodies on all bodies, exact or by a tree.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>
#include <vector>

#include "spall/comm.hpp"
#include "spall/types.hpp"
#include "state/gravity.hpp"

namespace spall {

/// The field at the owned bodies, at one instant.
struct GravityField {
  std::vector<Vec3>
      acceleration;  ///< m/s^2; sum of mass * acceleration over all ranks is zero to round-off
  std::vector<double> potential;  ///< J/kg, self excluded; energy = 1/2 sum m potential
  std::vector<double>
      rate;  ///< m/s^3, upper bound of |d acceleration / dt| at the present velocities
};

/// Owned bodies' rows in, owned bodies' field out. Coincident bodies exert no force on each other.
/// Without velocities on any rank `rate` is left empty. Throws Error on every rank for masses that
/// are negative or infinite: a body that never moves cannot take part. Collective.
GravityField evaluate_gravity(const Comm& comm, const GravitySettings& settings,
                              std::span<const double> mass, std::span<const Vec3> position,
                              std::span<const Vec3> velocity);

/// The field of all bodies at this rank's `places`; a body that lies there adds nothing. No rates.
/// Collective.
GravityField evaluate_gravity_at(const Comm& comm, const GravitySettings& settings,
                                 std::span<const double> mass, std::span<const Vec3> position,
                                 std::span<const Vec3> places);

/// What `automatic` means for so many bodies (of all ranks): the tree where it takes less than half
/// the time of the exact sum. Other methods are returned as they are.
GravityMethod choose_gravity(const GravitySettings& settings, std::int64_t bodies);

/// The chosen method in words.
std::string describe_gravity(const GravitySettings& settings, std::int64_t bodies);

/// Of some bodies; of all, the sums of what ranks have, and the fastest.
struct ForceChange {
  double squares = 0;  ///< N^2, sum of forces squared
  double bodies = 0;   ///< how many
  double fastest = 0;  ///< N/s, the largest m_b |da_b/dt|
};

/// Of owned bodies. The field needs rates.
ForceChange force_change(std::span<const double> mass, const GravityField& field);

/// How long a field may be held: until some force m_b |da_b| may have changed by `refresh` times
/// the rms force m |a| over all bodies. Seconds; infinite without forces. It holds for the
/// velocities at which the field was evaluated.
double holding_time(const GravitySettings& settings, const ForceChange& of_all);

}  // namespace spall
