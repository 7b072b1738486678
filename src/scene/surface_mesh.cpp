// Edges are matched once; distances come from a tree of boxes.
// SPDX-License-Identifier: BSD-3-Clause
#include "scene/surface_mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <string_view>
#include <type_traits>

#include "base/sort_by_key.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

std::string words(const Vec3& v) {
  return fmt::format("({:.6g}, {:.6g}, {:.6g})", v.x(), v.y(), v.z());
}

/// The words of a line, one after another; "" at its end.
class Words {
 public:
  explicit Words(std::string_view line) : rest_(line) {}
  std::string_view next() {
    constexpr std::string_view blanks = " \t\r\v\f";
    rest_.remove_prefix(std::min(rest_.find_first_not_of(blanks), rest_.size()));
    const std::string_view word = rest_.substr(0, rest_.find_first_of(blanks));
    rest_.remove_prefix(word.size());
    return word;
  }

 private:
  std::string_view rest_;
};

/// Whether the word begins with a number; what is behind it.
template <class T>
bool read_number(std::string_view word, T& number, std::string_view& behind) {
  if (word.starts_with('+') && !word.starts_with("+-")) word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  behind = word.substr(static_cast<std::size_t>(end - word.data()));
  if constexpr (std::is_floating_point_v<T>)
    if (error == std::errc::result_out_of_range)  // 0 of what is too small
      return std::abs(number = std::strtod(std::string(word).c_str(), nullptr)) < 1;
  return error == std::errc();
}

/// The vertex of a face's corner, "7", "7/1" or "7//3"; negative ones count from the last vertex.
/// -1: none of so many vertices.
std::int32_t vertex_of(std::string_view corner, std::size_t vertices) {
  std::int64_t number = 0;
  std::string_view behind;
  const bool is_number =
      read_number(corner, number, behind) && (behind.empty() || behind.starts_with('/'));
  const auto count = static_cast<std::int64_t>(vertices);
  const std::int64_t index = number < 0 ? count + number : number - 1;
  return is_number && index >= 0 && index < count ? static_cast<std::int32_t>(index) : -1;
}

double squared_distance_to_box(const Vec3& low, const Vec3& high, const Vec3& point) {
  return (low - point).cwiseMax(point - high).cwiseMax(0).squaredNorm();
}

}  // namespace

SurfaceMesh::SurfaceMesh(std::vector<Vec3> vertices, std::vector<Triangle> triangles,
                         const std::string& name)
    : SurfaceMesh(std::move(vertices), std::move(triangles), name, false) {}

SurfaceMesh::SurfaceMesh(std::vector<Vec3> vertices, std::vector<Triangle> triangles,
                         const std::string& name, bool centred)
    : vertices_(std::move(vertices)), triangles_(std::move(triangles)) {
  require(!triangles_.empty(), "{}: no faces", name);
  measure();
  if (volume_ < 0) {
    for (Triangle& t : triangles_) std::swap(t[1], t[2]);
    measure();
  }
  weigh_normals(name);
  match_edges(name);
  require(volume_ > 0, "{}: the surface encloses no volume", name);
  // After the normals: a triangle of the file may collapse where coordinates become larger.
  if (centred) {
    const Vec3 middle = center_;
    for (Vec3& vertex : vertices_) vertex -= middle;
    measure();
  }
  const auto count = static_cast<std::int32_t>(triangles_.size());
  faces_.reserve(triangles_.size());
  for (std::int32_t f = 0; f < count; ++f) {
    const auto& [a, b, c] = triangles_[f];
    faces_.push_back({{vertices_[a], vertices_[b], vertices_[c]}, f});
  }
  build(0, count);
}

SurfaceMesh SurfaceMesh::from_obj(const std::string& text, const std::string& file, double unit) {
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
  std::vector<std::int32_t> corners;
  std::string_view rest = text, behind;
  for (std::int64_t number = 1; !rest.empty(); ++number) {
    const std::string_view line = rest.substr(0, rest.find('\n'));
    rest.remove_prefix(std::min(line.size() + 1, rest.size()));
    Words words_of_line(line);
    const std::string_view kind = words_of_line.next();
    const auto place = [&] { return fmt::format("{}:{}", file, number); };
    if (kind == "v") {
      Vec3 vertex = Vec3::Zero();
      constexpr double most = 1e50;  // as of the numbers of a case
      for (double& x : vertex)
        if (!read_number(words_of_line.next(), x, behind) || !behind.empty() ||
            !(std::abs(x) <= most))
          throw Error(fmt::format("{}: three coordinates up to {} are wanted", place(), most));
      vertices.push_back(unit * vertex);
    } else if (kind == "f") {
      corners.clear();
      for (std::string_view corner; !(corner = words_of_line.next()).empty();) {
        corners.push_back(vertex_of(corner, vertices.size()));
        if (corners.back() < 0)
          throw Error(
              fmt::format("{}: the face's corner \"{}\" is none of the {} vertices above it",
                          place(), corner, vertices.size()));
      }
      if (corners.size() < 3) throw Error(fmt::format("{}: a face needs three corners", place()));
      for (std::size_t k = 2; k < corners.size(); ++k)
        triangles.push_back({corners[0], corners[k - 1], corners[k]});
    }
  }
  return {std::move(vertices), std::move(triangles), file, true};
}

/// Sums over the tetrahedra between the triangles and a point (Gauss's theorem).
void SurfaceMesh::measure() {
  const Vec3 origin = vertices_[triangles_[0][0]];
  volume_ = 0;
  Vec3 moment = Vec3::Zero();
  half_.setZero();
  for (const Triangle& t : triangles_) {
    const Vec3 a = vertices_[t[0]] - origin, b = vertices_[t[1]] - origin,
               c = vertices_[t[2]] - origin;
    const double part = a.dot(b.cross(c)) / 6;
    volume_ += part;
    moment += part * (a + b + c) / 4;
    for (std::int32_t v : t) half_ = half_.cwiseMax(vertices_[v].cwiseAbs());
  }
  center_ = origin + moment / volume_;
}

/// Finds the triangle beyond each edge: edges that join the same vertices follow each other once
/// they are sorted.
void SurfaceMesh::match_edges(const std::string& name) {
  std::vector<KeyedRow> order;
  order.reserve(3 * triangles_.size());
  for (std::size_t f = 0; f < triangles_.size(); ++f) {
    const Triangle& t = triangles_[f];
    for (int k = 0; k < 3; ++k) {
      const auto [least, most] = std::minmax(t[k], t[(k + 1) % 3]);
      order.push_back({static_cast<std::uint64_t>(least) << 32 | static_cast<std::uint64_t>(most),
                       static_cast<Index>(3 * f + k)});
    }
  }
  sort_by_key(order);
  const auto from = [&](Index row) { return triangles_[row / 3][row % 3]; };
  const auto to = [&](Index row) { return triangles_[row / 3][(row + 1) % 3]; };
  const auto edge = [&](Index row) {
    return fmt::format("the edge from {} to {}", words(vertices_[from(row)]),
                       words(vertices_[to(row)]));
  };
  // What is told is the first fault of the file, not of the sorted edges.
  constexpr Index none = std::numeric_limits<Index>::max();
  Index folded = none, open = none;
  beyond_.resize(triangles_.size());
  for (std::size_t first = 0, last; first < order.size(); first = last) {
    const Index one = order[first].row;
    last = first + 1;
    while (last < order.size() && order[last].key == order[first].key) ++last;
    if (last == first + 1) {
      open = std::min(open, one);
      continue;
    }
    const Index other = order[first + 1].row;
    if (from(one) == from(other))
      folded = std::min(folded, other);
    else if (last > first + 2)  // of three that join the same vertices two run the same way
      folded = std::min(folded, order[first + 2].row);
    beyond_[one / 3][one % 3] = other / 3;
    beyond_[other / 3][other % 3] = one / 3;
  }
  if (folded != none)
    throw Error(
        fmt::format("{}: two triangles run the same way through {}: the surface is "
                    "folded, or some of its faces are turned",
                    name, edge(folded)));
  if (open != none)
    throw Error(
        fmt::format("{}: the surface is open: only one triangle has {}; an inside needs a "
                    "closed one",
                    name, edge(open)));
}

void SurfaceMesh::weigh_normals(const std::string& name) {
  vertex_normal_.assign(vertices_.size(), Vec3::Zero());
  face_normal_.reserve(triangles_.size());
  for (const Triangle& t : triangles_) {
    const Vec3 &a = vertices_[t[0]], &b = vertices_[t[1]], &c = vertices_[t[2]];
    const Vec3 normal = (b - a).cross(c - a);
    if (!(normal.squaredNorm() > 0))
      throw Error(fmt::format("{}: the triangle at {} has no area", name, words(a)));
    face_normal_.push_back(normal.normalized());
    for (int k = 0; k < 3; ++k) {
      const Vec3& at = vertices_[t[k]];
      const Vec3 u = vertices_[t[(k + 1) % 3]] - at, w = vertices_[t[(k + 2) % 3]] - at;
      vertex_normal_[t[k]] += std::atan2(u.cross(w).norm(), u.dot(w)) * face_normal_.back();
    }
  }
}

std::int32_t SurfaceMesh::build(std::int32_t first, std::int32_t last) {
  const auto place = static_cast<std::int32_t>(nodes_.size());
  Node node{Vec3::Constant(infinity), Vec3::Constant(-infinity), first, last, -1};
  for (std::int32_t k = first; k < last; ++k)
    for (const Vec3& corner : faces_[k].corner) {
      node.low = node.low.cwiseMin(corner);
      node.high = node.high.cwiseMax(corner);
    }
  nodes_.push_back(node);
  constexpr std::int32_t leaf = 4;
  if (last - first <= leaf) return place;
  int axis = 0;
  (node.high - node.low).maxCoeff(&axis);
  const auto middle = (first + last) / 2;
  const auto center = [&](const Face& face) {
    return face.corner[0][axis] + face.corner[1][axis] + face.corner[2][axis];
  };
  std::nth_element(faces_.begin() + first, faces_.begin() + middle, faces_.begin() + last,
                   [&](const Face& f, const Face& g) { return center(f) < center(g); });
  build(first, middle);
  const std::int32_t right = build(middle, last);
  nodes_[place].right = right;
  return place;
}

double SurfaceMesh::depth(const Vec3& point) const {
  Nearest nearest;
  search(0, point, nearest);
  const double distance = std::sqrt(nearest.distance2);
  return (point - nearest.point).dot(normal_of(nearest.part)) > 0 ? -distance : distance;
}

void SurfaceMesh::search(std::int32_t place, const Vec3& point, Nearest& nearest) const {
  const Node& node = nodes_[place];
  if (node.right < 0) {
    for (std::int32_t k = node.first; k < node.last; ++k) visit(faces_[k], point, nearest);
    return;
  }
  const auto distance2 = [&](std::int32_t half) {
    return squared_distance_to_box(nodes_[half].low, nodes_[half].high, point);
  };
  std::int32_t near = place + 1, far = node.right;
  if (distance2(far) < distance2(near)) std::swap(near, far);
  if (distance2(near) < nearest.distance2) search(near, point, nearest);
  if (distance2(far) < nearest.distance2) search(far, point, nearest);
}

/// The nearest point of a triangle by the region of its plane that `point` lies over: a corner, an
/// edge or the inside (Ericson 2005, Real-Time Collision Detection, 5.1.5). By sides of edges, all
/// with one normal: it may be rounding error where a triangle is a sliver, but what lies on the
/// inner side of all edges is over the triangle still.
void SurfaceMesh::visit(const Face& face, const Vec3& point, Nearest& nearest) {
  const auto offer = [&](const Vec3& q, decltype(Part::kind) kind, std::int32_t k) {
    const double d2 = (point - q).squaredNorm();
    if (d2 < nearest.distance2) nearest = {d2, q, {kind, face.triangle, k}};
  };
  const auto& corner = face.corner;
  if (squared_distance_to_box(corner[0].cwiseMin(corner[1]).cwiseMin(corner[2]),
                              corner[0].cwiseMax(corner[1]).cwiseMax(corner[2]),
                              point) > nearest.distance2)
    return;
  const Vec3 normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
  bool inside = true;
  for (int k = 0; k < 3; ++k) {
    const Vec3 edge = corner[(k + 1) % 3] - corner[k], from = point - corner[k];
    if (from.dot(normal.cross(edge)) >= 0) continue;  // on the inner side
    inside = false;
    const double along = from.dot(edge) / edge.squaredNorm();
    if (along <= 0)
      offer(corner[k], Part::corner, k);
    else if (along >= 1)
      offer(corner[(k + 1) % 3], Part::corner, (k + 1) % 3);
    else
      offer(corner[k] + along * edge, Part::edge, k);
  }
  if (inside)
    offer(point - (point - corner[0]).dot(normal) / normal.squaredNorm() * normal, Part::inside, 0);
}

Vec3 SurfaceMesh::normal_of(const Part& part) const {
  const auto [kind, triangle, k] = part;
  switch (kind) {
    case Part::corner:
      return vertex_normal_[triangles_[triangle][k]];
    case Part::edge:
      return face_normal_[triangle] + face_normal_[beyond_[triangle][k]];
    case Part::inside:
      break;
  }
  return face_normal_[triangle];
}

}  // namespace spall
