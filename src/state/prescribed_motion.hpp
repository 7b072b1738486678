// Motions that a case prescribes: where a group's bodies are at a time, whatever acts on them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "spall/types.hpp"

namespace spall {

/// How far each point of a rigid group goes between two times.
struct RigidDisplacement {
  Vec3 point = Vec3::Zero();                       ///< m, on the axis at the start
  Vec3 shift = Vec3::Zero();                       ///< m
  Eigen::Matrix3d turn = Eigen::Matrix3d::Zero();  ///< rotation less the identity

  /// m, of the body that was at `anchor` at the start.
  Vec3 of(const Vec3& anchor) const;
};

/// m/s: velocities between two, component by component, and to each of them any by which a body
/// goes round an axis.
struct VelocityRange {
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();
  double turning = 0;

  void add(const Vec3& velocity);
};

/// A rigid motion as a function of the run's time alone, so that nothing drifts:
///
///   x(t) = point + d(t) - d(0) + R(rate t about axis) (x(0) - point)
///   d(t) = velocity t + amplitude sin(2 pi t/period + phase) + table(t)
///
/// The table goes straight from displacement to displacement, or follows velocities that change
/// linearly from time to time. Before its first and after its last time it rests.
struct PrescribedMotion {
  Vec3 velocity = Vec3::Zero();   ///< m/s
  Vec3 amplitude = Vec3::Zero();  ///< m, of an oscillation
  double period = infinity;       ///< s
  double phase = 0;               ///< rad
  Vec3 point = Vec3::Zero();      ///< m, on the axis at the start
  Vec3 axis = Vec3::UnitZ();      ///< unit vector
  double rate = 0;                ///< rad/s

  /// Sets the table to displacements (m) at times (s), which ascend.
  void set_displacements(std::vector<double> times, std::vector<Vec3> displacements);
  /// Sets the table to velocities (m/s) at times (s), which ascend.
  void set_velocities(std::vector<double> times, std::vector<Vec3> velocities);

  /// From time `from` to time `to`, s; differences do not cancel for short intervals.
  RigidDisplacement displacement(double from, double to) const;
  Vec3 spin() const { return rate * axis; }  ///< rad/s
  /// What steps of `h` (s) do not see of the table's way, of its range: how far it is, at its own
  /// times and half-way between them, beyond all places between those h/2 before and h/2 after.
  double unseen_by_steps(double h) const;
  /// m/s^2: no larger one drives the body that was at `anchor`, from time `from` to time `to`.
  /// Jumps of velocity are no accelerations: they are impacts.
  double largest_acceleration(const Vec3& anchor, double from = -infinity,
                              double to = infinity) const;
  /// Holds all velocities of the body that was at `anchor`, from time `from` to a later time `to`.
  VelocityRange velocities(const Vec3& anchor, double from, double to) const;

 private:
  Vec3 tabulated(double t) const;
  VelocityRange velocities_of_table(double from, double to) const;

  std::vector<double> times_;
  std::vector<Vec3> displacements_;
  std::vector<Vec3> velocities_;  // empty: constant between two times
};

}  // namespace spall
