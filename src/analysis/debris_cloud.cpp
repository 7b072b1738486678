// Percentiles by bisection, maps and fragments by sums: nothing is gathered.
// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/debris_cloud.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "scene/shape.hpp"
#include "scene/shields.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

/// A body's place and velocity in the frame of the plate.
struct Flight {
  double depth, radius;          ///< m: behind the rear face; from the line of flight
  double axial, radial;          ///< m/s
  std::array<double, 2> across;  ///< m
};

Flight flight_of(const Target& target, const Vec3& position, const Vec3& velocity) {
  const Vec3 x = position - target.origin;
  const auto across = [&](const Vec3& v) {
    return Eigen::Vector2d(v.dot(target.across[0]), v.dot(target.across[1]));
  };
  const Eigen::Vector2d at = across(x);
  return {x.dot(target.normal),
          at.norm(),
          velocity.dot(target.normal),
          across(velocity).norm(),
          {at[0], at[1]}};
}

bool is_debris(const Target& target, const Flight& flight) {
  return flight.depth > target.clearance();
}

/// Calls `f(row, flight)` for this rank's bodies of projectile and plate.
template <class F>
void for_each_body(const Bodies& bodies, const Target& target, F&& f) {
  for (Index b = 0; b < bodies.owned; ++b)
    if (bodies.group[b] == target.projectile || bodies.group[b] == target.plate)
      f(b, flight_of(target, bodies.position[b], bodies.velocity[b]));
}

/// Values with weights, and the part of the weight below the value that is looked for.
struct Sample {
  double fraction;
  std::vector<std::pair<double, double>> values = {};
};

/// For each sample the smallest value with at least that part of all ranks' weight at or below it;
/// 0 of no values. All by the same bisections. Collective.
std::vector<double> percentiles(const Comm& comm, std::vector<Sample> samples) {
  const std::size_t n = samples.size();
  std::vector<double> ends(2 * n, -infinity), total(n, 0.0), result(n, 0.0);
  for (std::size_t s = 0; s < n; ++s) {
    auto& values = samples[s].values;
    std::sort(values.begin(), values.end());
    for (auto& [value, weight] : values) weight = total[s] += weight;
    if (values.empty()) continue;
    ends[s] = -values.front().first;
    ends[n + s] = values.back().first;
  }
  comm.max(ends);
  comm.sum(total);
  constexpr int bisections = 50;
  std::vector<double> low(n), high(ends.begin() + static_cast<std::ptrdiff_t>(n), ends.end());
  for (std::size_t s = 0; s < n; ++s) low[s] = -ends[s];
  std::vector<double> below(n);
  for (int k = 0; k < bisections; ++k) {
    for (std::size_t s = 0; s < n; ++s) {
      const auto& values = samples[s].values;
      const auto end = std::upper_bound(values.begin(), values.end(),
                                        std::pair((low[s] + high[s]) / 2, infinity));
      below[s] = end == values.begin() ? 0 : std::prev(end)->second;
    }
    comm.sum(below);
    for (std::size_t s = 0; s < n; ++s)
      (below[s] >= samples[s].fraction * total[s] ? high[s] : low[s]) = (low[s] + high[s]) / 2;
  }
  for (std::size_t s = 0; s < n; ++s)
    if (total[s] > 0) result[s] = high[s];
  return result;
}

/// Sums on square pixels from `low` on and about the line of flight, as many as are needed to reach
/// so far, but no more than a thousand.
class Map {
 public:
  static Map along(double pixel, double low, double length, double half_width) {
    return {pixel, low, pixels(length / pixel), pixels(2 * half_width / pixel)};
  }
  static Map across(double pixel, double half_width) {
    const std::size_t count = pixels(2 * half_width / pixel);
    return {pixel, -pixel * static_cast<double>(count) / 2, count, count};
  }
  void add(double x, double y, double value) {
    const auto at = [&](double place, int k) {
      return static_cast<std::ptrdiff_t>(std::floor((place - low_[k]) / pixel_));
    };
    const auto column = at(x, 0), row = at(y, 1);
    if (column < 0 || row < 0 || column >= static_cast<std::ptrdiff_t>(columns_) ||
        row >= static_cast<std::ptrdiff_t>(rows_))
      return;
    sums_[static_cast<std::size_t>(row) * columns_ + static_cast<std::size_t>(column)] += value;
  }
  std::vector<double>& sums() { return sums_; }
  /// m, extents of what is above `threshold`.
  std::array<double, 2> extents(double threshold) const {
    std::array<std::size_t, 2> low{columns_, rows_}, high{0, 0};
    for (std::size_t k = 0; k < sums_.size(); ++k) {
      if (sums_[k] <= threshold) continue;
      const std::array<std::size_t, 2> at{k % columns_, k / columns_};
      for (int d = 0; d < 2; ++d) {
        low[d] = std::min(low[d], at[d]);
        high[d] = std::max(high[d], at[d] + 1);
      }
    }
    const auto extent = [&](int d) {
      return high[d] > low[d] ? pixel_ * static_cast<double>(high[d] - low[d]) : 0.0;
    };
    return {extent(0), extent(1)};
  }

 private:
  static std::size_t pixels(double count) {
    constexpr double most = 1000;  // what flies further is not seen
    return static_cast<std::size_t>(std::clamp(std::ceil(count), 1.0, most));
  }
  Map(double pixel, double low, std::size_t columns, std::size_t rows)
      : pixel_(pixel),
        low_{low, -pixel * static_cast<double>(rows) / 2},
        columns_(columns),
        rows_(rows),
        sums_(columns * rows, 0.0) {}
  double pixel_;
  std::array<double, 2> low_;
  std::size_t columns_, rows_;
  std::vector<double> sums_;
};

void measure_contour(const Comm& comm, const Bodies& bodies, const Target& target, Cloud& cloud) {
  std::array<double, 2> reach{0, 0};
  for_each_body(bodies, target, [&](Index, const Flight& f) {
    if (!is_debris(target, f)) return;
    reach = {std::max(reach[0], f.depth), std::max(reach[1], f.radius)};
  });
  comm.max(reach);
  const double start = target.clearance(), pixel = target.diameter / 4;
  for (int view = 0; view < 2; ++view) {
    Map map = Map::along(pixel, start, reach[0] + pixel - start, reach[1] + pixel);
    for_each_body(bodies, target, [&](Index b, const Flight& f) {
      if (is_debris(target, f)) map.add(f.depth, f.across[view], bodies.mass[b]);
    });
    comm.sum(map.sums());
    const auto extents = map.extents(target.diameter / 100 * target.density * pixel * pixel);
    cloud.contour_length = std::max(cloud.contour_length, extents[0]);
    cloud.contour_width += extents[1] / 2;
  }
}

/// Seen along the normal, in rings of sectors: the first ring from which on, over the next D/4, the
/// plate is there. 0 where that is narrower than three of the plate's bodies: so wide may gaps
/// between them look in a whole plate.
void measure_hole(const Comm& comm, const Bodies& bodies, const Target& target, Cloud& cloud) {
  constexpr int sectors = 12, ahead = 4;
  const double width = target.diameter / (4 * ahead);
  const int rings = static_cast<int>(target.half_width / width);
  if (rings <= 0) return;  // the line of flight meets the plate's rim
  std::vector<double> part(static_cast<std::size_t>(sectors * rings), 0.0);
  const double reach = target.clearance();
  double largest = 0;
  for_each_body(bodies, target, [&](Index b, const Flight& f) {
    if (bodies.group[b] != target.plate) return;
    largest = std::max(largest, bodies.radius[b]);
    const int ring = static_cast<int>(f.radius / width);
    const bool there = f.depth < reach && f.depth > -target.thickness - reach;
    if (!there || ring >= rings) return;
    const double turn = std::atan2(f.across[1], f.across[0]) / (2 * pi) + 0.5;
    const int sector = std::min(static_cast<int>(turn * sectors), sectors - 1);
    const double area = pi / sectors * width * width * (2 * ring + 1);
    part[static_cast<std::size_t>(sector * rings + ring)] +=
        bodies.mass[b] / (area * target.areal_density);
  });
  comm.sum(part);
  double sum = 0, squares = 0;
  bool ends = true;  // before the plate does
  for (int s = 0; s < sectors; ++s) {
    const double* f = &part[static_cast<std::size_t>(s * rings)];
    int edge = 0;
    const auto mean = [&](int count) {
      double m = 0;
      for (int k = edge; k < edge + count; ++k) m += f[k] / count;
      return m;
    };
    const auto open = [&] { return f[edge] < 0.5 || mean(ahead) < 0.5; };
    while (edge + ahead < rings && open()) ++edge;
    ends &= edge + ahead < rings || rings < ahead || !open();
    // The ring before may hold the rest of what ends in this one.
    const double filled = std::min(f[edge], 1.0) + (edge > 0 ? std::min(f[edge - 1], 0.5) : 0);
    const double hole = 2 * std::max(0.0, width * (edge + 1 - filled));
    sum += hole / sectors;
    squares += hole * hole / sectors;
  }
  if (sum < 6 * comm.max(largest)) return;
  cloud.hole = sum;
  cloud.hole_spread = ends ? std::sqrt(std::max(0.0, squares - sum * sum)) : std::nan("");
}

/// m along the normal: how far the plate has gone, by its bodies that are no farther than it is
/// thick from `middle`, the median of their depths.
double way_of_plate(const Comm& comm, const Bodies& bodies, const Target& target, double middle) {
  std::array<double, 2> sums{};  // mass, and times depth
  for_each_body(bodies, target, [&](Index b, const Flight& f) {
    if (bodies.group[b] != target.plate || std::abs(f.depth - middle) > target.thickness) return;
    sums[0] += bodies.mass[b];
    sums[1] += bodies.mass[b] * f.depth;
  });
  comm.sum(sums);
  return sums[0] > 0 ? sums[1] / sums[0] + target.thickness / 2 : 0;
}

}  // namespace

Target find_target(const Case& scene, const DebrisPlate& measured) {
  Target t;
  t.projectile = scene.debris->projectile;
  t.plate = measured.group;
  const Group& ball = scene.groups[t.projectile];
  const Group& plate = scene.groups[t.plate];
  const int thin = thin_axis(plate.volume);
  const Vec3 normal = plate.volume.axes.col(thin);
  t.normal = ball.velocity.dot(normal) < 0 ? Vec3(-normal) : normal;
  t.diameter = width_across(ball.volume, ball.velocity.normalized());
  t.speed = ball.velocity.norm();
  t.thickness = plate.volume.extents[thin];
  const double volume = volume_of(plate.volume);
  t.area = volume / t.thickness;
  t.areal_density =
      plate.total_mass.value_or(scene.materials[plate.material].density * volume) / t.area;
  t.density = scene.materials[ball.material].density;
  for (std::size_t k = 0; const Group* group : {&ball, &plate}) {
    const auto& solid = scene.materials[group->material].solid;
    t.melt_energy[k] = solid ? solid->melt_energy : 0;
    t.sublimation_energy[k++] = solid ? solid->sublimation_energy : 0;
  }

  // Along the flight to the plate's middle; from there straight to its rear face.
  const double way = t.normal.dot(plate.volume.center - ball.volume.center);
  t.origin = ball.volume.center + way / ball.velocity.dot(t.normal) * ball.velocity +
             t.thickness / 2 * t.normal;
  t.half_width = infinity;
  for (int k = 0; k < 2; ++k) {
    const int side = (thin + 1 + k) % 3;
    t.across[k] = plate.volume.axes.col(side);
    t.half_width =
        std::min(t.half_width, plate.volume.extents[side] / 2 -
                                   std::abs(t.across[k].dot(t.origin - plate.volume.center)));
  }
  return t;
}

Cloud measure_cloud(const Comm& comm, const Bodies& bodies, const Target& target, double time) {
  Cloud cloud{.time = time};
  std::vector<Sample> samples{{0.99}, {0.01}, {0.99}, {0.01}, {0.99}, {0.99}, {0.5}};
  struct Part {
    double mass = 0, momentum = 0, melted = 0, vapour = 0;  // kg, kg m/s, kg, kg
  };
  std::array<Part, 4> parts;
  const auto& [projectile, plate, ejecta, left] = parts;
  for_each_body(bodies, target, [&](Index b, const Flight& f) {
    const double m = bodies.mass[b];
    const std::size_t origin = bodies.group[b] == target.plate ? 1 : 0;
    const auto add = [&](Part& part) {
      part.mass += m;
      part.momentum += m * f.axial;
      if (!bodies.has(Field::heat)) return;
      if (bodies.heat[b] > target.melt_energy[origin] * m) part.melted += m;
      if (bodies.heat[b] > target.sublimation_energy[origin] * m) part.vapour += m;
    };
    if (origin == 1) samples.back().values.emplace_back(f.depth, m);
    if (is_debris(target, f)) {
      const double values[] = {f.axial, f.axial, f.radial, f.depth, f.depth, f.radius};
      for (std::size_t s = 0; s < std::size(values); ++s)
        samples[s].values.emplace_back(values[s], m);
      add(parts[origin]);
    } else if (f.depth < -target.thickness - target.clearance() && f.axial < 0) {
      add(parts[2]);
    } else if (origin == 1) {
      add(parts[3]);
    }
  });
  comm.sum(std::span(&parts[0].mass, parts.size() * sizeof(Part) / sizeof(double)));
  const auto share = [](double of, double all) { return all > 0 ? of / all : 0; };
  const auto hotter = [&](double of, double all, double than) {
    return bodies.has(Field::heat) && than > 0 ? share(of, all) : std::nan("");
  };
  cloud.projectile_mass = projectile.mass;
  cloud.projectile_momentum = projectile.momentum;
  cloud.projectile_melted = hotter(projectile.melted, projectile.mass, target.melt_energy[0]);
  cloud.projectile_vapour =
      hotter(projectile.vapour, projectile.mass, target.sublimation_energy[0]);
  cloud.plate_mass = plate.mass;
  cloud.plate_momentum = plate.momentum;
  cloud.plate_melted = hotter(plate.melted, plate.mass, target.melt_energy[1]);
  cloud.plate_vapour = hotter(plate.vapour, plate.mass, target.sublimation_energy[1]);
  cloud.ejecta_mass = ejecta.mass;
  cloud.ejecta_momentum = ejecta.momentum;
  cloud.centre = share(projectile.momentum + plate.momentum, projectile.mass + plate.mass);
  cloud.plate_speed = share(left.momentum, left.mass);
  const std::vector<double> p = percentiles(comm, std::move(samples));
  cloud.front = p[0];
  cloud.rear = p[1];
  cloud.radial = p[2];
  cloud.length = p[4] - p[3];
  cloud.width = 2 * p[5];
  cloud.plate_moved = way_of_plate(comm, bodies, target, p[6]);
  measure_contour(comm, bodies, target, cloud);
  measure_hole(comm, bodies, target, cloud);
  return cloud;
}

Fragments find_fragments(const Comm& comm, const Ghosts& ghosts, const Bodies& bodies,
                         const Links& links, const Target& target) {
  std::vector<BodyId> name = find_clumps(comm, ghosts, bodies, links);
  std::vector<char> chosen(bodies.owned, 0);
  for_each_body(bodies, target,
                [&](Index b, const Flight& f) { chosen[b] = is_debris(target, f); });
  for (Index b = 0; b < bodies.owned; ++b)
    if (!chosen[b]) name[b] = -1;
  constexpr int most_decades = std::numeric_limits<std::int64_t>::digits10 + 1;
  std::array<double, 2 + most_decades> sums{};  // pieces, singles, by decades
  double largest = 0;
  for (const Clump& clump : share_of_clumps(comm, bodies, name)) {
    largest = std::max(largest, clump.mass);
    if (clump.count == 1) {
      ++sums[1];
      continue;
    }
    ++sums[0];
    std::size_t decade = 0;
    for (std::int64_t n = clump.count; n >= 10; n /= 10) ++decade;
    ++sums[2 + decade];
  }
  comm.sum(sums);
  Fragments fragments{.pieces = static_cast<std::int64_t>(sums[0]),
                      .singles = static_cast<std::int64_t>(sums[1]),
                      .largest = comm.max(largest),
                      .counts = {}};
  fragments.counts.assign(sums.begin() + 2, sums.end());
  while (!fragments.counts.empty() && fragments.counts.back() == 0) fragments.counts.pop_back();
  return fragments;
}

WallLoad load_wall(const Comm& comm, const Bodies& bodies, const Target& target, double distance) {
  const double pixel = target.diameter / 2;
  std::vector<Sample> samples{{0.5}, {0.9}};
  Map map = Map::across(pixel, 2 * distance);
  WallLoad load;
  for_each_body(bodies, target, [&](Index b, const Flight& f) {
    if (!is_debris(target, f) || f.axial <= 0) return;
    const double momentum = bodies.mass[b] * f.axial;
    // Also what has gone farther: where it came through.
    const double left = (distance - f.depth) / f.axial;  // s
    const Flight hit =
        flight_of(target, bodies.position[b] + left * bodies.velocity[b], bodies.velocity[b]);
    load.momentum += momentum;
    for (Sample& sample : samples) sample.values.emplace_back(hit.radius, momentum);
    map.add(hit.across[0], hit.across[1], momentum);
  });
  load.momentum = comm.sum(load.momentum);
  comm.sum(map.sums());
  const auto p = percentiles(comm, std::move(samples));
  load.half_radius = p[0];
  load.radius = p[1];
  load.peak = *std::max_element(map.sums().begin(), map.sums().end()) / (pixel * pixel);
  return load;
}

}  // namespace spall
