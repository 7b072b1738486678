// Shifts and turns between two times, by formulas that do not cancel.
// SPDX-License-Identifier: BSD-3-Clause
#include "state/prescribed_motion.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace spall {
namespace {

/// R - 1 of a turn by `angle` (rad) about the unit vector `axis` (Rodrigues).
Eigen::Matrix3d turn_less_identity(const Vec3& axis, double angle) {
  Eigen::Matrix3d cross;
  cross << 0, -axis.z(), axis.y(), axis.z(), 0, -axis.x(), -axis.y(), axis.x(), 0;
  const double half = std::sin(angle / 2);
  return std::sin(angle) * cross + 2 * half * half * cross * cross;
}

/// The least and the largest cosine of an angle (rad) between `from` and `to`.
std::array<double, 2> cosines_between(double from, double to) {
  const auto passes = [&](double angle) {  // or a full turn before or behind it
    return std::floor((to - angle) / (2 * pi)) > std::floor((from - angle) / (2 * pi));
  };
  const auto [least, most] = std::minmax({std::cos(from), std::cos(to)});
  return {passes(pi) ? -1 : least, passes(0) ? 1 : most};
}

}  // namespace

Vec3 RigidDisplacement::of(const Vec3& anchor) const {
  return shift + turn * (anchor - point);
}

void VelocityRange::add(const Vec3& velocity) {
  low = low.cwiseMin(velocity);
  high = high.cwiseMax(velocity);
}

void PrescribedMotion::set_displacements(std::vector<double> times,
                                         std::vector<Vec3> displacements) {
  times_ = std::move(times);
  displacements_ = std::move(displacements);
  velocities_.clear();
}

void PrescribedMotion::set_velocities(std::vector<double> times, std::vector<Vec3> velocities) {
  times_ = std::move(times);
  velocities_ = std::move(velocities);
  displacements_.assign(1, Vec3::Zero());
  for (std::size_t k = 1; k < times_.size(); ++k)
    displacements_.push_back(displacements_.back() + (times_[k] - times_[k - 1]) / 2 *
                                                         (velocities_[k - 1] + velocities_[k]));
}

Vec3 PrescribedMotion::tabulated(double t) const {
  if (times_.empty()) return Vec3::Zero();
  if (t <= times_.front()) return displacements_.front();
  if (t >= times_.back()) return displacements_.back();
  const auto next = std::ranges::upper_bound(times_, t) - times_.begin();
  const auto k = static_cast<std::size_t>(next - 1);
  const double span = times_[k + 1] - times_[k], since = t - times_[k], part = since / span;
  if (velocities_.empty())
    return displacements_[k] + part * (displacements_[k + 1] - displacements_[k]);
  return displacements_[k] +
         since * (velocities_[k] + part / 2 * (velocities_[k + 1] - velocities_[k]));
}

RigidDisplacement PrescribedMotion::displacement(double from, double to) const {
  RigidDisplacement moved{.point = point};
  moved.shift = (to - from) * velocity;
  if (!amplitude.isZero(0)) {
    const double w = 2 * pi / period;
    moved.shift +=
        2 * std::cos(w * (from + to) / 2 + phase) * std::sin(w * (to - from) / 2) * amplitude;
  }
  if (!times_.empty()) moved.shift += tabulated(to) - tabulated(from);
  if (rate != 0) {
    const Eigen::Matrix3d before = turn_less_identity(axis, rate * from);
    const Eigen::Matrix3d meanwhile = turn_less_identity(axis, rate * (to - from));
    moved.turn = meanwhile + meanwhile * before;
  }
  return moved;
}

double PrescribedMotion::unseen_by_steps(double h) const {
  double left = 0;
  Vec3 low = Vec3::Constant(infinity), high = Vec3::Constant(-infinity);
  const auto look = [&](double t) {
    const Vec3 place = tabulated(t), from = tabulated(t - h / 2), to = tabulated(t + h / 2);
    const Vec3 between = place.cwiseMax(from.cwiseMin(to)).cwiseMin(from.cwiseMax(to));
    left = std::max(left, (place - between).norm());
    low = low.cwiseMin(place);
    high = high.cwiseMax(place);
  };
  for (std::size_t k = 0; k < times_.size(); ++k) {
    if (k > 0) look((times_[k - 1] + times_[k]) / 2);
    look(times_[k]);
  }
  return left > 0 ? left / (high - low).norm() : 0;
}

double PrescribedMotion::largest_acceleration(const Vec3& anchor, double from, double to) const {
  const double w = 2 * pi / period;
  double largest = w * w * amplitude.norm() + rate * rate * axis.cross(anchor - point).norm();
  double in_table = 0;
  for (std::size_t k = 1; k < velocities_.size(); ++k)
    if (from < times_[k] && to > times_[k - 1])
      in_table = std::max(
          in_table, (velocities_[k] - velocities_[k - 1]).norm() / (times_[k] - times_[k - 1]));
  return largest + in_table;
}

VelocityRange PrescribedMotion::velocities_of_table(double from, double to) const {
  const bool rests = times_.empty() || from < times_.front() || to > times_.back();
  VelocityRange range;
  if (!rests) range = {Vec3::Constant(infinity), Vec3::Constant(-infinity), 0};
  for (std::size_t k = 0; k + 1 < times_.size(); ++k) {
    const double span = times_[k + 1] - times_[k];
    const double begin = std::max(from, times_[k]), end = std::min(to, times_[k + 1]);
    if (begin >= end) continue;
    if (velocities_.empty()) {
      range.add((displacements_[k + 1] - displacements_[k]) / span);
      continue;
    }
    for (double t : {begin, end})
      range.add(velocities_[k] + (t - times_[k]) / span * (velocities_[k + 1] - velocities_[k]));
  }
  return range;
}

VelocityRange PrescribedMotion::velocities(const Vec3& anchor, double from, double to) const {
  VelocityRange range = velocities_of_table(from, to);
  range.low += velocity;
  range.high += velocity;
  if (!amplitude.isZero(0)) {
    const double w = 2 * pi / period;
    const auto [least, most] = cosines_between(w * from + phase, w * to + phase);
    const Vec3 one = w * least * amplitude, other = w * most * amplitude;
    range.low += one.cwiseMin(other);
    range.high += one.cwiseMax(other);
  }
  range.turning = std::abs(rate) * axis.cross(anchor - point).norm();
  return range;
}

}  // namespace spall
