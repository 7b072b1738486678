// The few types that every other file speaks in.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <limits>
#include <vector>

namespace spall {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
/// As numbers lie in arrays, x, y, z, w: of an alignment that no set of instructions changes.
using Quaternion = Eigen::Quaternion<double, Eigen::DontAlign>;

/// A body's place in this rank's arrays: dies at the next migration.
using Index = std::int32_t;

/// A body's name for ever: 0 … N-1 in the order of the case file, the same on any number of ranks.
using BodyId = std::int64_t;

/// Row of the other side of a contact with a plane: a body that never moves.
inline constexpr Index ground = -1;

inline constexpr double pi = 3.14159265358979323846;
inline constexpr double infinity = std::numeric_limits<double>::infinity();

/// Moment of inertia of a uniform sphere, over m r^2.
inline constexpr double sphere_inertia = 0.4;
/// kg m^2, of a uniform sphere of `mass` (kg) and `radius` (m) about its centre.
inline double moment_of_inertia(double mass, double radius) {
  return sphere_inertia * mass * radius * radius;
}

/// The doubles of an array of vectors, three a row.
inline double* flat(std::vector<Vec3>& rows) {
  return reinterpret_cast<double*>(rows.data());
}

}  // namespace spall
