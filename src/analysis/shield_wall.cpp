// Maps of square pixels, a quarter of a spacing wide, seen along the wall's normal: all ranks hold
// the same, and nothing else is gathered.
// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/shield_wall.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>

#include "analysis/clumps.hpp"
#include "scene/packing.hpp"
#include "scene/shape.hpp"
#include "scene/shields.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

constexpr double pixels_a_spacing = 4, most_pixels = 2000;
constexpr double seen_beyond = 0.25;  // of a half width: a free wall may drift across
constexpr double smoothing = 1.5;     // spacings, radius of the circle that thickness is of
constexpr double smallest_spall = 4;  // bodies: pi d^2 of a close-packed layer holds 3.6
/// Spacings behind the rear surface, beyond which a piece has left it; of single bodies, which may
/// have failed there and ride on it, in a layer or two.
constexpr double gap_of_pieces = 1, gap_of_singles = 2;
constexpr double plate_like = 0.5;   // thickness over width, at most
constexpr double nearly = 1 - 1e-9;  // of a sum of masses on many ranks

/// A point as the wall sees it.
struct Seen {
  double x, y, depth;  ///< m
};
Seen see(const WallFrame& frame, const Vec3& position) {
  const Vec3 from = position - frame.center;
  return {from.dot(frame.across[0]), from.dot(frame.across[1]), from.dot(frame.normal)};
}

/// Square pixels about the wall's middle, and beyond its edges.
class Grid2 {
 public:
  explicit Grid2(const ShieldWall& wall) : pixel(wall.spacing / pixels_a_spacing) {
    for (int k = 0; k < 2; ++k) {
      const double half = (1 + seen_beyond) * wall.half_width[k];
      counts[k] = 2 * static_cast<std::ptrdiff_t>(std::ceil(half / pixel));
      low_[k] = -pixel * static_cast<double>(counts[k] / 2);
    }
  }
  std::size_t size() const { return static_cast<std::size_t>(counts[0] * counts[1]); }
  double x(std::ptrdiff_t column) const { return middle(column, 0); }
  double y(std::ptrdiff_t row) const { return middle(row, 1); }
  std::size_t index(std::ptrdiff_t column, std::ptrdiff_t row) const {
    return static_cast<std::size_t>(row * counts[0] + column);
  }
  /// The pixel of a place, or the nearest one to it.
  std::size_t nearest(double at_x, double at_y) const { return index(of(at_x, 0), of(at_y, 1)); }

  /// Calls `f(pixel, r^2)` for the pixels whose middles are nearer than `radius` (m) to a place.
  template <class F>
  void for_each_near(double at_x, double at_y, double radius, F&& f) const {
    const auto first_row = of(at_y - radius, 1), last_row = of(at_y + radius, 1);
    const auto first_column = of(at_x - radius, 0), last_column = of(at_x + radius, 0);
    for (auto row = first_row; row <= last_row; ++row)
      for (auto column = first_column; column <= last_column; ++column) {
        const double dx = x(column) - at_x, dy = y(row) - at_y;
        const double r2 = dx * dx + dy * dy;
        if (r2 < radius * radius) f(index(column, row), r2);
      }
  }

  const double pixel;                          ///< m
  std::array<std::ptrdiff_t, 2> counts{0, 0};  ///< columns, rows

 private:
  double middle(std::ptrdiff_t at, int k) const {
    return low_[k] + pixel * (static_cast<double>(at) + 0.5);
  }
  std::ptrdiff_t of(double place, int k) const {
    const double at = std::floor((place - low_[k]) / pixel);
    return static_cast<std::ptrdiff_t>(std::clamp(at, 0.0, static_cast<double>(counts[k] - 1)));
  }
  std::array<double, 2> low_{};  ///< m
};

/// What bodies make of each pixel.
struct Maps {
  std::vector<double> nearness;  ///< -m^2: minus the squared distance of the nearest body, if
                                 ///< that is nearer than a spacing; else -infinity
  std::vector<double> rear;      ///< m, depth of the rearmost body that is so near
  std::vector<double> columns;   ///< 1/m^2, bodies behind each other, smoothed

  explicit Maps(std::size_t size)
      : nearness(size, -infinity), rear(size, -infinity), columns(size, 0.0) {}
  bool open(std::size_t pixel) const { return nearness[pixel] == -infinity; }
};

void draw(const Grid2& grid, double spacing, const Seen& body, Maps& maps) {
  grid.for_each_near(body.x, body.y, spacing, [&](std::size_t pixel, double r2) {
    maps.nearness[pixel] = std::max(maps.nearness[pixel], -r2);
    maps.rear[pixel] = std::max(maps.rear[pixel], body.depth);
  });
  // (1 - q^2)^2, whose integral over the circle of radius R is pi R^2/3.
  const double radius = smoothing * spacing, radius2 = radius * radius;
  grid.for_each_near(body.x, body.y, radius, [&](std::size_t pixel, double r2) {
    const double left = 1 - r2 / radius2;
    maps.columns[pixel] += 3 / (pi * radius2) * left * left;
  });
}

void sum_over_ranks(const Comm& comm, Maps& maps) {
  comm.max(maps.nearness);
  comm.max(maps.rear);
  comm.sum(maps.columns);
}

/// What is judged: all but the rim, about the middle of what is seen.
class Window {
 public:
  Window(const ShieldWall& wall, const std::array<double, 2>& middle)
      : middle_(middle), round_(wall.round) {
    for (int k = 0; k < 2; ++k)
      half_[k] = wall.half_width[k] - rim_of(wall.half_width[k], wall.spacing);
  }
  bool contains(double x, double y) const {
    const double at_x = (x - middle_[0]) / half_[0], at_y = (y - middle_[1]) / half_[1];
    return round_ ? at_x * at_x + at_y * at_y <= 1 : std::abs(at_x) <= 1 && std::abs(at_y) <= 1;
  }

 private:
  std::array<double, 2> middle_, half_{};
  bool round_;
};

/// m: a wall that drifts or flies apart is followed by the middles of its rows and columns of
/// pixels, of which the median is taken: neither holes nor a few flaps change it.
std::array<double, 2> middle_of(const Grid2& grid, const Maps& maps) {
  std::array<double, 2> middle{0, 0};
  for (int k = 0; k < 2; ++k) {
    std::vector<double> middles;
    for (std::ptrdiff_t line = 0; line < grid.counts[1 - k]; ++line) {
      std::ptrdiff_t first = -1, last = -1;
      for (std::ptrdiff_t at = 0; at < grid.counts[k]; ++at) {
        if (maps.open(k == 0 ? grid.index(at, line) : grid.index(line, at))) continue;
        if (first < 0) first = at;
        last = at;
      }
      if (first < 0) continue;
      const auto place = [&](std::ptrdiff_t at) { return k == 0 ? grid.x(at) : grid.y(at); };
      middles.push_back((place(first) + place(last)) / 2);
    }
    if (middles.empty()) continue;
    const auto half = middles.begin() + std::ssize(middles) / 2;
    std::nth_element(middles.begin(), half, middles.end());
    middle[k] = *half;
  }
  return middle;
}

/// Calls `f(column, row, pixel)` for each pixel of the window.
template <class F>
void for_each_judged(const Grid2& grid, const Window& window, F&& f) {
  for (std::ptrdiff_t row = 0; row < grid.counts[1]; ++row)
    for (std::ptrdiff_t column = 0; column < grid.counts[0]; ++column)
      if (window.contains(grid.x(column), grid.y(row))) f(column, row, grid.index(column, row));
}

struct Openings {
  std::int64_t count = 0;
  double largest = 0;  ///< m^2
  bool at_edge = false;
};

Openings find_openings(const Grid2& grid, const Maps& maps, const Window& window, double spacing) {
  Openings found;
  // Where the middle of a sphere that passes may be, and then all that it sweeps.
  std::vector<char> swept(grid.size(), 0);
  for_each_judged(grid, window, [&](std::ptrdiff_t column, std::ptrdiff_t row, std::size_t pixel) {
    if (!maps.open(pixel)) return;
    const double x = grid.x(column), y = grid.y(row);
    for (const double step : {-grid.pixel, grid.pixel})
      found.at_edge |= !window.contains(x + step, y) || !window.contains(x, y + step);
    grid.for_each_near(x, y, spacing / 2, [&](std::size_t near, double) { swept[near] = 1; });
  });
  std::vector<std::size_t> front;
  const auto take = [&](std::size_t pixel) {
    if (!swept[pixel]) return;
    swept[pixel] = 0;
    front.push_back(pixel);
  };
  for (std::size_t first = 0; first < swept.size(); ++first) {
    if (!swept[first]) continue;
    ++found.count;
    std::int64_t pixels = 0;
    for (take(first); !front.empty(); ++pixels) {
      const auto pixel = static_cast<std::ptrdiff_t>(front.back());
      front.pop_back();
      const std::ptrdiff_t column = pixel % grid.counts[0], row = pixel / grid.counts[0];
      if (column > 0) take(grid.index(column - 1, row));
      if (column + 1 < grid.counts[0]) take(grid.index(column + 1, row));
      if (row > 0) take(grid.index(column, row - 1));
      if (row + 1 < grid.counts[1]) take(grid.index(column, row + 1));
    }
    found.largest = std::max(found.largest, static_cast<double>(pixels) * grid.pixel * grid.pixel);
  }
  return found;
}

double diameter_of_circle(double area) {
  return 2 * std::sqrt(area / pi);
}
double diameter_of_ball(double volume) {
  return std::cbrt(6 * volume / pi);
}

/// kg m^2: the second moments of a piece's mass about its middle. Collective.
Eigen::Matrix3d spread_of(const Comm& comm, const Bodies& bodies, const std::vector<BodyId>& name,
                          const Clump& piece) {
  std::array<double, 9> sums{};
  Eigen::Map<Eigen::Matrix3d> spread(sums.data());
  for (Index b = 0; b < bodies.owned; ++b) {
    if (name[b] != piece.name) continue;
    const Vec3 off = bodies.position[b] - piece.position;
    spread += bodies.mass[b] * off * off.transpose();
  }
  comm.sum(sums);
  return spread;
}

/// Of the main piece where it is now: its normal is the way in which it is thinnest. What is left
/// of a wall may be no plate any more: then it is seen along the normal of the start. A wall that
/// moves and turns by less than a pixel is seen in the same ones.
WallFrame frame_of(const Comm& comm, const Bodies& bodies, const std::vector<BodyId>& name,
                   const Clump& main, const ShieldWall& wall) {
  const WallFrame& start = wall.start;
  const double pixel = wall.spacing / pixels_a_spacing;
  const Vec3 moved = main.position - start.center;
  WallFrame frame = start;
  frame.center += moved.dot(start.normal) * start.normal;
  for (const Vec3& across : start.across)
    frame.center += pixel * std::round(moved.dot(across) / pixel) * across;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread_of(comm, bodies, name, main));
  const Vec3& along = axes.eigenvalues();
  if (along[0] > plate_like * plate_like * along[1]) return frame;
  const Vec3 thin = axes.eigenvectors().col(0);
  const Vec3 normal = thin.dot(start.normal) < 0 ? Vec3(-thin) : thin;
  const double widest = std::max(wall.half_width[0], wall.half_width[1]);
  if ((normal - start.normal).norm() * widest < pixel) return frame;
  frame.normal = normal;
  const auto turn = Eigen::Quaterniond::FromTwoVectors(start.normal, frame.normal);
  for (Vec3& across : frame.across) across = turn * across;
  return frame;
}

/// The pieces of a group's bodies, as find_clumps() names them; -1 of others.
std::vector<BodyId> pieces_of_group(const Comm& comm, const LinkedBodies& linked,
                                    std::int32_t group) {
  const Bodies& bodies = linked.bodies;
  Links own;
  for (std::size_t k = 0; k < linked.links.i.size(); ++k) {
    const Index i = linked.links.i[k], j = linked.links.j[k];
    if (bodies.group[i] != group || bodies.group[j] != group) continue;
    own.i.push_back(i);
    own.j.push_back(j);
  }
  std::vector<BodyId> name = find_clumps(comm, linked.ghosts, bodies, own);
  for (Index b = 0; b < bodies.size(); ++b)
    if (bodies.group[b] != group) name[b] = -1;
  return name;
}

/// Adds up the pieces that have left the rear; `name` are those of the other pieces alone.
void weigh_spall(const Comm& comm, const Bodies& bodies, const std::vector<BodyId>& name,
                 const ShieldWall& wall, const Clump& main, const WallFrame& frame,
                 const Grid2& grid, const Maps& maps, const Window& window, WallVerdict& verdict) {
  const double main_rear = wall.thickness / 2;
  std::array<double, 4> sums{};  // pieces, mass, momentum; mass from the rim
  double largest = 0;
  for (const Clump& piece : share_of_clumps(comm, bodies, name)) {
    const Seen at = see(frame, piece.position);
    const std::size_t pixel = grid.nearest(at.x, at.y);
    const double rear = maps.open(pixel) ? main_rear : maps.rear[pixel];
    const Vec3 motion = piece.velocity - main.velocity;
    const double speed = motion.dot(frame.normal);
    const double gap = (piece.count > 1 ? gap_of_pieces : gap_of_singles) * wall.spacing;
    if (at.depth <= rear + gap || speed <= 0) continue;
    // It flies freely: where it was as deep as the rear. What a cloud blows off the wall's edges,
    // which a wider plate has not, flies past the rim.
    const double since = (at.depth - rear) / speed;  // s
    if (!window.contains(at.x - since * motion.dot(frame.across[0]),
                         at.y - since * motion.dot(frame.across[1]))) {
      sums[3] += piece.mass;
      continue;
    }
    sums[0] += 1;
    sums[1] += piece.mass;
    sums[2] += piece.mass * speed;
    largest = std::max(largest, piece.mass);
  }
  comm.sum(sums);
  verdict.spall_pieces = static_cast<std::int64_t>(sums[0]);
  verdict.spall_mass = sums[1];
  verdict.spall_speed = sums[1] > 0 ? sums[2] / sums[1] : 0;
  verdict.spall_largest = comm.max(largest);
  verdict.rim_mass = sums[3];
}

/// When and where something that flies freely comes to the face of the wall before it.
struct Arrival {
  double left;   ///< s
  double x, y;   ///< m
  double speed;  ///< m/s, along the normal
};

/// None of what is in the wall or flies away from it. `motion` (m/s): against the wall.
std::optional<Arrival> arrival_of(const WallFrame& frame, double thickness, const Vec3& position,
                                  const Vec3& motion) {
  const Seen at = see(frame, position);
  const double speed = (at.depth < 0 ? 1 : -1) * motion.dot(frame.normal);
  const double gap = std::abs(at.depth) - thickness / 2;
  if (gap <= 0 || speed <= 0) return {};
  const double left = gap / speed;
  return Arrival{.left = left,
                 .x = at.x + left * motion.dot(frame.across[0]),
                 .y = at.y + left * motion.dot(frame.across[1]),
                 .speed = speed};
}

/// Share of the energy that flew at the wall, from either side, of what will still meet it, or is
/// on its way through it.
double share_still_coming(const Comm& comm, const Bodies& bodies, const ShieldWall& wall,
                          const Clump& main, const WallFrame& frame) {
  std::array<double, 2> energy{};  // still coming, at the start
  const auto before_wall = [&](double x, double y) {
    return std::abs(x) <= wall.half_width[0] && std::abs(y) <= wall.half_width[1];
  };
  for (Index b = 0; b < bodies.owned; ++b) {
    const double m = bodies.mass[b];
    if (bodies.group[b] == wall.group || !std::isfinite(m)) continue;
    const Vec3 motion = bodies.velocity[b] - main.velocity;
    const Seen at = see(frame, bodies.position[b]);
    for (const auto& approach : wall.approaches) {
      if (bodies.group[b] != approach.group) continue;
      energy[1] += m / 2 * approach.speed * approach.speed;
      const double along = motion.dot(frame.normal);
      if (std::abs(at.depth) <= wall.thickness / 2 && before_wall(at.x, at.y))
        energy[0] += m / 2 * along * along;
    }
    const auto meets = arrival_of(frame, wall.thickness, bodies.position[b], motion);
    if (meets && before_wall(meets->x, meets->y)) energy[0] += m / 2 * meets->speed * meets->speed;
  }
  comm.sum(energy);
  return energy[1] > 0 ? energy[0] / energy[1] : 0;
}

/// m from the wall's middle: nearer to it, what flew at it has left the plates before it behind by
/// twice its own width, and three quarters of the way to the wall. What will part has done so by
/// then: at 4 km/s balls hang together for six diameters.
double where_clear(const Case& scene, const ShieldWall& wall, const Group& flying) {
  constexpr double last_part = 0.25;
  const double from = see(wall.start, flying.volume.center).depth;
  const double width = 2 * half_widths(flying.volume).maxCoeff();
  double clear = infinity;
  for (const Group& plate : scene.groups) {
    const int thin = axis_through(plate.volume);
    const double depth = see(wall.start, plate.volume.center).depth;
    const bool between = depth * from > 0 && std::abs(depth) < std::abs(from);
    if (thin < 0 || !between || plate.name == wall.name) continue;
    const double face = wall.thickness / 2;
    const double rear = std::abs(depth) - plate.volume.extents[thin] / 2;
    clear = std::min({clear, rear - 2 * width, face + last_part * (rear - face)});
  }
  return clear;
}

/// The form and the motion of one of the pieces `name`, against the wall. Collective.
Coming describe_piece(const Comm& comm, const Bodies& bodies, std::vector<BodyId> name,
                      BodyId largest, double density, const Clump& wall) {
  for (BodyId& one : name)
    if (one != largest) one = -1;
  const Clump piece = heaviest_clumps(comm, bodies, name, 1).front();
  const double volume = piece.mass / density;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread_of(comm, bodies, name, piece) /
                                                            piece.mass);
  // Of the same radius of gyration: a body is as wide as a cube of its volume.
  const double own = std::pow(volume / static_cast<double>(piece.count), 2. / 3) / 12;
  const Vec3 radii = (axes.eigenvalues().reverse().array().max(0) + own).sqrt();
  Eigen::Matrix3d turned = axes.eigenvectors().rowwise().reverse();
  if (turned.determinant() < 0) turned.col(2) *= -1;
  const Eigen::AngleAxisd turn(turned);
  const double diameter = diameter_of_ball(volume);
  return {.diameter = diameter,
          .density = density,
          .size = diameter / std::cbrt(radii.prod()) * radii,
          .rotation = turn.angle() * turn.axis(),
          .velocity = piece.velocity - wall.velocity};
}

/// The heaviest piece of the wall. `name`: its bodies' pieces.
Clump main_piece(const Comm& comm, const Bodies& bodies, const std::vector<BodyId>& name,
                 const ShieldWall& wall) {
  const std::vector<Clump> pieces = heaviest_clumps(comm, bodies, name, 1);
  require(!pieces.empty(), "the wall \"{}\" has no bodies", wall.name);
  return pieces.front();
}

}  // namespace

const char* name_of(Outcome outcome) {
  switch (outcome) {
    case Outcome::held:
      return "held";
    case Outcome::detached_spall:
      return "detached spall";
    case Outcome::perforated:
      return "perforated";
  }
  return "";
}

ShieldWall lay_wall(const Comm& comm, const Case& scene, const Shield& shield) {
  const Group& group = scene.groups[shield.wall];
  ShieldWall wall{.name = group.name,
                  .section = results_of(shield),
                  .group = shield.wall,
                  .start = {.center = group.volume.center, .normal = shield.rear},
                  .approaches = {}};
  const int thin = axis_through(group.volume);
  wall.thickness = group.volume.extents[thin];
  wall.round = group.volume.shape == Shape::cylinder;
  wall.spacing = wall.distance = lattice_of(group.packing).distance;
  wall.density = scene.materials[group.material].density;
  for (int k = 0; k < 2; ++k) {
    const int axis = (thin + 1 + k) % 3;
    wall.start.across[k] = group.volume.axes.col(axis);
    wall.half_width[k] = group.volume.extents[axis] / 2;
    wall.spacing = std::max(
        wall.spacing, 2 * (1 + seen_beyond) * wall.half_width[k] * pixels_a_spacing / most_pixels);
  }
  for (std::size_t g = 0; g < scene.groups.size(); ++g) {
    const double speed = speed_from_either_side(group, scene.groups[g], wall.start.normal);
    if (speed > 0)
      wall.approaches.push_back({.group = static_cast<std::int32_t>(g),
                                 .speed = speed,
                                 .clear = where_clear(scene, wall, scene.groups[g]),
                                 .density = scene.materials[scene.groups[g].material].density});
  }

  // The recipe alone: every rank runs through it, and draws its share.
  const Grid2 grid(wall);
  Maps maps(grid.size());
  std::int64_t count = 0;
  group.packing.type->place({.volume = group.volume,
                             .packing = group.packing,
                             .seed = stream_of(scene, static_cast<std::size_t>(shield.wall)),
                             .place = group.place,
                             .is_free = [](const Vec3&, double) { return true; },
                             .put =
                                 [&](const PackedSphere& sphere) {
                                   if (count++ % comm.size == comm.rank)
                                     draw(grid, wall.spacing, see(wall.start, sphere.center), maps);
                                 }});
  sum_over_ranks(comm, maps);
  const double filled = filled_by(group, count);
  require(group.total_mass || std::abs(filled - 1) <= most_unfilled,
          "{}.wall = \"{}\": its bodies have {:.3g} of the mass of such a wall, as a lattice of "
          "whole spheres along its faces has: packing.orientation = \"random\" fills it",
          shield.place, wall.name, filled);
  const Window window(wall, {0, 0});
  const Openings openings = find_openings(grid, maps, window, wall.spacing);
  require(
      openings.count == 0,
      "{}.wall = \"{}\": it has an opening of {:.3g} m before anything has met it: nothing could "
      "be judged",
      shield.place, wall.name, diameter_of_circle(openings.largest));
  std::vector<double> columns;
  for_each_judged(grid, window, [&](std::ptrdiff_t, std::ptrdiff_t, std::size_t pixel) {
    columns.push_back(maps.columns[pixel]);
  });
  const auto half = columns.begin() + std::ssize(columns) / 2;
  std::nth_element(columns.begin(), half, columns.end());
  wall.columns = *half;
  return wall;
}

void Coming::add(const Coming& other) {
  const double past = std::max(passes, other.passes);
  if (other.meets > meets) *this = other;
  passes = past;
}

bool is_coarse(const ShieldWall& wall, const Coming& coming) {
  // With two to four across walls held that failed with so many: cases/breakup.
  constexpr double across = 7;
  // Diameters: twice what Cour-Palais's formula asks of aluminium under aluminium at 8 km/s.
  constexpr double thick = 9;
  return coming.meets > 0 && coming.diameter < across * wall.distance &&
         wall.thickness < thick * coming.diameter * std::sqrt(coming.density / wall.density);
}

Coming look_at_what_comes(const Comm& comm, const LinkedBodies& linked, const ShieldWall& wall) {
  const Bodies& bodies = linked.bodies;
  const std::vector<BodyId> own = pieces_of_group(comm, linked, wall.group);
  const Clump main = main_piece(comm, bodies, own, wall);
  const WallFrame frame = frame_of(comm, bodies, own, main, wall);
  const Window window(wall, {0, 0});
  Coming coming;
  for (const ShieldWall::Approach& approach : wall.approaches) {
    const std::vector<BodyId> name = pieces_of_group(comm, linked, approach.group);
    std::array<double, 2> most{};  // J, of what meets and of what passes
    BodyId largest = -1;
    for (const Clump& piece : share_of_clumps(comm, bodies, name)) {
      if (std::abs(see(frame, piece.position).depth) > approach.clear) continue;
      const auto arrival =
          arrival_of(frame, wall.thickness, piece.position, piece.velocity - main.velocity);
      if (!arrival) continue;
      const double energy = piece.mass / 2 * arrival->speed * arrival->speed;
      const bool meets = window.contains(arrival->x, arrival->y);
      if (meets && energy > most[0]) largest = piece.name;
      most[meets ? 0 : 1] = std::max(most[meets ? 0 : 1], energy);
    }
    const double most_here = most[0];
    comm.max(most);
    if (most_here < most[0]) largest = -1;
    largest = static_cast<BodyId>(comm.max(static_cast<double>(largest)));
    Coming of_group;
    if (largest >= 0)
      of_group = describe_piece(comm, bodies, name, largest, approach.density, main);
    of_group.meets = most[0];
    of_group.passes = most[1];
    coming.add(of_group);
  }
  return coming;
}

void keep_spall(WallVerdict& most, WallVerdict& verdict) {
  if (verdict.outcome == Outcome::detached_spall && verdict.spall_mass > most.spall_mass)
    most = verdict;
  if (verdict.outcome != Outcome::held || most.outcome != Outcome::detached_spall) return;
  verdict.outcome = Outcome::detached_spall;
  verdict.margin = most.margin;
  verdict.spall_pieces = most.spall_pieces;
  verdict.spall_mass = most.spall_mass;
  verdict.spall_largest = most.spall_largest;
  verdict.spall_speed = most.spall_speed;
}

WallVerdict judge_wall(const Comm& comm, const LinkedBodies& linked, const ShieldWall& wall) {
  const Bodies& bodies = linked.bodies;
  std::vector<BodyId> name = pieces_of_group(comm, linked, wall.group);
  std::array<double, 2> all{};  // bodies of the wall, and their mass
  for (Index b = 0; b < bodies.owned; ++b) {
    if (bodies.group[b] != wall.group) continue;
    all[0] += 1;
    all[1] += bodies.mass[b];
  }
  comm.sum(all);
  const Clump main = main_piece(comm, bodies, name, wall);
  const WallFrame frame = frame_of(comm, bodies, name, main, wall);
  const Grid2 grid(wall);
  Maps maps(grid.size());
  for (Index b = 0; b < bodies.owned; ++b) {
    if (name[b] != main.name) continue;
    draw(grid, wall.spacing, see(frame, bodies.position[b]), maps);
    name[b] = -1;
  }
  sum_over_ranks(comm, maps);
  const Window window(wall, middle_of(grid, maps));

  WallVerdict verdict;
  double thinnest = infinity;
  for_each_judged(grid, window, [&](std::ptrdiff_t, std::ptrdiff_t, std::size_t pixel) {
    thinnest = std::min(thinnest, maps.columns[pixel]);
  });
  verdict.thinnest = thinnest / wall.columns * wall.thickness;
  const Openings openings = find_openings(grid, maps, window, wall.spacing);
  verdict.openings = openings.count;
  verdict.opening_at_edge = openings.at_edge;
  verdict.hole = diameter_of_circle(openings.largest);
  weigh_spall(comm, bodies, name, wall, main, frame, grid, maps, window, verdict);
  verdict.least_spall = nearly * smallest_spall * all[1] / all[0];
  verdict.still_coming = share_still_coming(comm, bodies, wall, main, frame);

  if (verdict.openings > 0) {
    verdict.outcome = Outcome::perforated;
    verdict.margin = -verdict.hole / wall.thickness;
  } else if (verdict.spall_mass >= verdict.least_spall) {
    const double volume =
        wall.thickness * 4 * wall.half_width[0] * wall.half_width[1] * (wall.round ? pi / 4 : 1);
    verdict.outcome = Outcome::detached_spall;
    verdict.margin = -diameter_of_ball(volume * verdict.spall_mass / all[1]) / wall.thickness;
  } else {
    verdict.margin = verdict.thinnest / wall.thickness;
  }
  return verdict;
}

}  // namespace spall
