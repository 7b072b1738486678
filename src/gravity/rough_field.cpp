// Points, eight at a time.
// SPDX-License-Identifier: BSD-3-Clause
#include "gravity/rough_field.hpp"

#include "spall/error.hpp"

namespace spall {

RoughField::RoughField(const Comm& comm, std::span<const Stretch> stretches,
                       std::span<const KeyedRow> rows, std::span<const double> mass,
                       std::span<const Vec3> position, const Vec3& origin) {
  std::vector<std::array<double, 4>> sums;  // m x, m
  std::vector<double> radii;
  const auto for_each = [&](auto&& visit) {
    std::size_t at = 0;
    for (const Stretch& s : stretches) {
      if (s.children[0] != Cell::none) continue;
      for (std::size_t k = first_at(rows, s.low); k < rows.size() && rows[k].key < s.high; ++k)
        visit(at, position[rows[k].row] - origin, mass[rows[k].row]);
      ++at;
    }
    return at;
  };
  sums.resize(stretches.size());
  const std::size_t count = for_each([&](std::size_t s, const Vec3& x, double m) {
    for (int k = 0; k < 3; ++k) sums[s][k] += m * x[k];
    sums[s][3] += m;
  });
  comm.sum(std::span(sums[0].data(), 4 * count));
  for (std::size_t s = 0; s < count; ++s)
    if (sums[s][3] > 0)
      for (int k = 0; k < 3; ++k) sums[s][k] /= sums[s][3];
  radii.resize(count);
  for_each([&](std::size_t s, const Vec3& x, double) {
    radii[s] = std::max(radii[s], (x - Vec3::Map(sums[s].data())).squaredNorm());
  });
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, radii.data(), static_cast<int>(count), MPI_DOUBLE, MPI_MAX,
                          comm.raw),
            "MPI_Allreduce");
  pullers_.resize((count + lane_count - 1) / lane_count);
  for (std::size_t s = 0; s < count; ++s) {
    Puller& p = pullers_[s / lane_count];
    const std::size_t lane = s % lane_count;
    p.x[lane] = sums[s][0];
    p.y[lane] = sums[s][1];
    p.z[lane] = sums[s][2];
    p.mass[lane] = sums[s][3];
    p.softening[lane] = radii[s];
  }
}

RoughField::Sample RoughField::at(const Vec3& place, std::size_t own) const {
  Lanes x{}, y{}, z{}, sum{}, gradient{};
  for (std::size_t k = 0; k < pullers_.size(); ++k) {
    Puller p = pullers_[k];
    if (k == own / lane_count) p.mass[own % lane_count] = 0;
    const Lanes dx = p.x - place.x(), dy = p.y - place.y(), dz = p.z - place.z();
    const Lanes inverse = inverse_sqrt(dx * dx + (dy * dy + (dz * dz + p.softening)));
    const Lanes weight = p.mass * inverse * inverse;
    sum += weight;
    const Lanes cubed = weight * inverse;
    gradient += cubed;
    x += cubed * dx;
    y += cubed * dy;
    z += cubed * dz;
  }
  const Vec3 total(sum_of_lanes(x), sum_of_lanes(y), sum_of_lanes(z));
  return {std::max(total.norm(), 0.1 * sum_of_lanes(sum)), sum_of_lanes(gradient)};
}

}  // namespace spall
