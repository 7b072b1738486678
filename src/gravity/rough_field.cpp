// Points, eight at a time.
// SPDX-License-Identifier: BSD-3-Clause
#include "gravity/rough_field.hpp"

#include <algorithm>
#include <cmath>

namespace spall {

RoughField::RoughField(const Comm& comm, std::span<const Stretch> stretches,
                       std::span<const KeyedRow> rows, std::span<const double> mass,
                       std::span<const Vec3> position, const Vec3& origin)
    : stretches_(stretches), points_(stretches.size()) {
  const auto for_each_body = [&](auto&& visit) {
    for_each_stretch(stretches, rows, [&](Index s, std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k)
        visit(s, position[rows[k].row] - origin, mass[rows[k].row]);
    });
  };
  std::vector<std::array<double, 4>> sums(stretches.size());  // m x, m
  for_each_body([&](Index s, const Vec3& x, double m) {
    for (int k = 0; k < 3; ++k) sums[s][k] += m * x[k];
    sums[s][3] += m;
  });
  // Halves come after what they are halves of.
  const auto with_halves = [&](auto&& visit) {
    for (auto s = static_cast<Index>(stretches.size()); s-- > 0;)
      if (stretches[s].children[0] != Cell::none)
        for (Index half : stretches[s].children) visit(s, half);
  };
  comm.sum(std::span(sums[0].data(), 4 * sums.size()));
  with_halves([&](Index s, Index half) {
    for (int k = 0; k < 4; ++k) sums[s][k] += sums[half][k];
  });
  for (std::size_t s = 0; s < sums.size(); ++s) {
    points_[s].mass = sums[s][3];
    if (sums[s][3] > 0) points_[s].center = Vec3::Map(sums[s].data()) / sums[s][3];
  }
  std::vector<double> radii(stretches.size());
  for_each_body([&](Index s, const Vec3& x, double) {
    radii[s] = std::max(radii[s], (x - points_[s].center).norm());
  });
  comm.max(radii);
  with_halves([&](Index s, Index half) {
    radii[s] = std::max(radii[s], (points_[s].center - points_[half].center).norm() + radii[half]);
  });
  for (std::size_t s = 0; s < radii.size(); ++s) points_[s].radius = radii[s];
  find_groups();
}

/// A group is as much as a few generations of halves make: what is far from it is collected once.
void RoughField::find_groups() {
  constexpr int generations = 3;
  std::vector<int> below(stretches_.size(), 0);
  for (std::size_t s = stretches_.size(); s-- > 0;)
    if (stretches_[s].children[0] != Cell::none)
      for (Index half : stretches_[s].children) below[s] = std::max(below[s], below[half] + 1);
  group_.assign(stretches_.size(), Cell::none);
  for (std::size_t s = 0; s < stretches_.size(); ++s) {
    if (group_[s] == Cell::none && below[s] <= generations) group_[s] = static_cast<Index>(s);
    if (stretches_[s].children[0] != Cell::none)
      for (Index half : stretches_[s].children) group_[half] = group_[s];
  }
}

void RoughField::collect(Index s) {
  constexpr double opening = 0.7;  // radius over distance
  const Point &from = points_[seen_from_], &point = points_[s];
  const double apart = point.radius / opening + from.radius;
  const bool halved = stretches_[s].children[0] != Cell::none;
  if (halved && (point.center - from.center).squaredNorm() <= apart * apart) {
    for (Index half : stretches_[s].children) collect(half);
    return;
  }
  const std::size_t lane = pulling_.size() % lane_count;
  if (lane == 0) pullers_.emplace_back();
  Puller& p = pullers_.back();
  p.x[lane] = point.center.x();
  p.y[lane] = point.center.y();
  p.z[lane] = point.center.z();
  p.mass[lane] = point.mass;
  p.softening[lane] = halved ? 0 : point.radius * point.radius;
  pulling_.push_back(s);
}

void RoughField::look_from(std::uint64_t key) {
  if (present_ != Cell::none && key >= stretches_[present_].low && key < stretches_[present_].high)
    return;
  present_ = 0;
  while (stretches_[present_].children[0] != Cell::none) {
    const auto& halves = stretches_[present_].children;
    present_ = halves[key < stretches_[halves[1]].low ? 0 : 1];
  }
  if (seen_from_ != group_[present_]) {
    seen_from_ = group_[present_];
    pullers_.clear();
    pulling_.clear();
    collect(0);
  }
  own_ = std::ranges::find(pulling_, present_) - pulling_.begin();
}

namespace {
/// Where pulls cancel, their sum itself would have all cells opened.
double pull_of(double total, double sum_of_all) {
  return std::max(total, 0.1 * sum_of_all);
}
}  // namespace

RoughField::Sample RoughField::at(const Vec3& place) const {
  Lanes x{}, y{}, z{}, sum{}, trace{}, xx{}, xy{}, xz{}, yy{}, yz{}, zz{};
  for (std::size_t k = 0; k < pullers_.size(); ++k) {
    Puller p = pullers_[k];
    if (k == own_ / lane_count) p.mass[own_ % lane_count] = 0;
    const Lanes dx = p.x - place.x(), dy = p.y - place.y(), dz = p.z - place.z();
    const Lanes inverse = inverse_sqrt(dx * dx + (dy * dy + (dz * dz + p.softening)));
    const Lanes inverse2 = inverse * inverse;
    const Lanes weight = p.mass * inverse2;
    sum += weight;
    const Lanes cubed = weight * inverse;
    trace += cubed;
    const Lanes px = cubed * dx, py = cubed * dy, pz = cubed * dz;
    x += px;
    y += py;
    z += pz;
    const Lanes tx = inverse2 * dx, ty = inverse2 * dy, tz = inverse2 * dz;
    xx += tx * px;
    xy += tx * py;
    xz += tx * pz;
    yy += ty * py;
    yz += ty * pz;
    zz += tz * pz;
  }
  const Vec3 total(sum_of_lanes(x), sum_of_lanes(y), sum_of_lanes(z));
  const auto tide = [&](const Lanes& v) { return 3 * sum_of_lanes(v); };
  const Vec3 diagonal = Vec3(tide(xx), tide(yy), tide(zz)) - Vec3::Constant(sum_of_lanes(trace));
  const Vec3 beside(tide(xy), tide(xz), tide(yz));
  return {pull_of(total.norm(), sum_of_lanes(sum)),
          std::sqrt(diagonal.squaredNorm() + 2 * beside.squaredNorm())};
}

double RoughField::least_pull(const LaneVectors& places) const {
  Lanes pull_x{}, pull_y{}, pull_z{}, sum{};
  for (std::size_t k = 0; k < pulling_.size(); ++k) {
    const Puller& p = pullers_[k / lane_count];
    const std::size_t lane = k % lane_count;
    if (k == own_) continue;
    const Lanes dx = p.x[lane] - places.x, dy = p.y[lane] - places.y, dz = p.z[lane] - places.z;
    const Lanes inverse = inverse_sqrt(dx * dx + (dy * dy + (dz * dz + p.softening[lane])));
    const Lanes weight = p.mass[lane] * (inverse * inverse), cubed = weight * inverse;
    sum += weight;
    pull_x += cubed * dx;
    pull_y += cubed * dy;
    pull_z += cubed * dz;
  }
  const Lanes squared = pull_x * pull_x + (pull_y * pull_y + pull_z * pull_z);
  double least = infinity;
  for (std::size_t k = 0; k < lane_count; ++k)
    least = std::min(least, pull_of(std::sqrt(squared[k]), sum[k]));
  return least;
}

}  // namespace spall
