// Edges are matched once; distances come from a tree of boxes.
// SPDX-License-Identifier: BSD-3-Clause
#include "scene/surface_mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <sstream>

#include "spall/error.hpp"

namespace spall {
namespace {

std::string words(const Vec3& v) {
  return fmt::format("({:.6g}, {:.6g}, {:.6g})", v.x(), v.y(), v.z());
}

/// The vertex of a face's corner, "7", "7/1" or "7//3"; negative ones count from the last vertex.
std::int32_t vertex_of(const std::string& corner, std::size_t vertices, const std::string& place) {
  char* end = nullptr;
  const long number = std::strtol(corner.c_str(), &end, 10);
  const bool is_number = end != corner.c_str() && (*end == '\0' || *end == '/');
  const auto count = static_cast<long>(vertices);
  const long index = number < 0 ? count + number : number - 1;
  require(is_number && index >= 0 && index < count,
          "{}: the face's corner \"{}\" is none of the {} vertices above it", place, corner, count);
  return static_cast<std::int32_t>(index);
}

double squared_distance_to_box(const Vec3& low, const Vec3& high, const Vec3& point) {
  return (low - point).cwiseMax(point - high).cwiseMax(0).squaredNorm();
}

}  // namespace

SurfaceMesh::SurfaceMesh(std::vector<Vec3> vertices, std::vector<Triangle> triangles,
                         const std::string& name)
    : vertices_(std::move(vertices)), triangles_(std::move(triangles)) {
  require(!triangles_.empty(), "{}: no faces", name);
  measure();
  if (volume_ < 0) {
    for (Triangle& t : triangles_) std::swap(t[1], t[2]);
    measure();
  }
  weigh_normals(name);
  require(volume_ > 0, "{}: the surface encloses no volume", name);
  order_.resize(triangles_.size());
  std::iota(order_.begin(), order_.end(), 0);
  build(0, static_cast<std::int32_t>(order_.size()));
}

SurfaceMesh SurfaceMesh::from_obj(const std::string& text, const std::string& file, double unit) {
  std::istringstream in(text);
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
  std::string line;
  for (std::int64_t number = 1; std::getline(in, line); ++number) {
    std::istringstream words_of_line(line);
    std::string kind;
    words_of_line >> kind;
    const auto place = [&] { return fmt::format("{}:{}", file, number); };
    if (kind == "v") {
      Vec3 vertex;
      words_of_line >> vertex.x() >> vertex.y() >> vertex.z();
      constexpr double most = 1e50;  // as of the numbers of a case
      require(!words_of_line.fail() && vertex.cwiseAbs().maxCoeff() <= most,
              "{}: three coordinates up to {} are wanted", place(), most);
      vertices.push_back(unit * vertex);
    } else if (kind == "f") {
      std::vector<std::int32_t> corners;
      for (std::string corner; words_of_line >> corner;)
        corners.push_back(vertex_of(corner, vertices.size(), place()));
      require(corners.size() >= 3, "{}: a face needs three corners", place());
      for (std::size_t k = 2; k < corners.size(); ++k)
        triangles.push_back({corners[0], corners[k - 1], corners[k]});
    }
  }
  SurfaceMesh mesh(std::move(vertices), std::move(triangles), file);
  mesh.move(-mesh.center_);
  return mesh;
}

void SurfaceMesh::move(const Vec3& by) {
  for (Vec3& vertex : vertices_) vertex += by;
  for (Node& node : nodes_) {
    node.low += by;
    node.high += by;
  }
  measure();
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

void SurfaceMesh::weigh_normals(const std::string& name) {
  face_normal_.resize(triangles_.size());
  vertex_normal_.assign(vertices_.size(), Vec3::Zero());
  edge_normal_.resize(triangles_.size());
  std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> triangle_of;  // by directed edge
  for (std::size_t f = 0; f < triangles_.size(); ++f) {
    const Triangle& t = triangles_[f];
    const Vec3 &a = vertices_[t[0]], &b = vertices_[t[1]], &c = vertices_[t[2]];
    const Vec3 normal = (b - a).cross(c - a);
    require(normal.squaredNorm() > 0, "{}: the triangle at {} has no area", name, words(a));
    face_normal_[f] = normal.normalized();
    for (int k = 0; k < 3; ++k) {
      const auto from = t[k], to = t[(k + 1) % 3], other = t[(k + 2) % 3];
      const Vec3 u = vertices_[to] - vertices_[from], w = vertices_[other] - vertices_[from];
      vertex_normal_[from] += std::atan2(u.cross(w).norm(), u.dot(w)) * face_normal_[f];
      const bool fresh =
          triangle_of.emplace(std::pair(from, to), static_cast<std::int32_t>(f)).second;
      require(fresh,
              "{}: two triangles run the same way through the edge from {} to {}: the surface is "
              "folded, or some of its faces are turned",
              name, words(vertices_[from]), words(vertices_[to]));
    }
  }
  for (std::size_t f = 0; f < triangles_.size(); ++f)
    for (int k = 0; k < 3; ++k) {
      const auto from = triangles_[f][k], to = triangles_[f][(k + 1) % 3];
      const auto beyond = triangle_of.find({to, from});
      require(beyond != triangle_of.end(),
              "{}: the surface is open: only one triangle has the edge from {} to {}; an inside "
              "needs a closed one",
              name, words(vertices_[from]), words(vertices_[to]));
      edge_normal_[f][k] = face_normal_[f] + face_normal_[beyond->second];
    }
}

std::int32_t SurfaceMesh::build(std::int32_t first, std::int32_t last) {
  const auto place = static_cast<std::int32_t>(nodes_.size());
  Node node{Vec3::Constant(infinity), Vec3::Constant(-infinity), first, last, -1};
  for (std::int32_t k = first; k < last; ++k)
    for (std::int32_t v : triangles_[order_[k]]) {
      node.low = node.low.cwiseMin(vertices_[v]);
      node.high = node.high.cwiseMax(vertices_[v]);
    }
  nodes_.push_back(node);
  constexpr std::int32_t leaf = 4;
  if (last - first <= leaf) return place;
  int axis = 0;
  (node.high - node.low).maxCoeff(&axis);
  const auto middle = (first + last) / 2;
  const auto center = [&](std::int32_t f) {
    const Triangle& t = triangles_[f];
    return vertices_[t[0]][axis] + vertices_[t[1]][axis] + vertices_[t[2]][axis];
  };
  std::nth_element(order_.begin() + first, order_.begin() + middle, order_.begin() + last,
                   [&](std::int32_t f, std::int32_t g) { return center(f) < center(g); });
  build(first, middle);
  const std::int32_t right = build(middle, last);
  nodes_[place].right = right;
  return place;
}

double SurfaceMesh::depth(const Vec3& point) const {
  Nearest nearest;
  search(0, point, nearest);
  const double distance = std::sqrt(nearest.distance2);
  return (point - nearest.point).dot(nearest.normal) > 0 ? -distance : distance;
}

void SurfaceMesh::search(std::int32_t place, const Vec3& point, Nearest& nearest) const {
  const Node& node = nodes_[place];
  if (node.right < 0) {
    for (std::int32_t k = node.first; k < node.last; ++k) visit(order_[k], point, nearest);
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
/// edge or the face (Ericson 2005, Real-Time Collision Detection, 5.1.5).
void SurfaceMesh::visit(std::int32_t f, const Vec3& point, Nearest& nearest) const {
  const Triangle& t = triangles_[f];
  const auto offer = [&](const Vec3& q, const Vec3& normal) {
    const double d2 = (point - q).squaredNorm();
    if (d2 < nearest.distance2) nearest = {d2, q, normal};
  };
  bool over_face = true;
  for (int k = 0; k < 3; ++k) {
    const Vec3 &a = vertices_[t[k]], &b = vertices_[t[(k + 1) % 3]];
    const Vec3 edge = b - a;
    if ((point - a).dot(face_normal_[f].cross(edge)) >= 0) continue;  // on the inner side
    over_face = false;
    const double along = (point - a).dot(edge) / edge.squaredNorm();
    if (along <= 0)
      offer(a, vertex_normal_[t[k]]);
    else if (along >= 1)
      offer(b, vertex_normal_[t[(k + 1) % 3]]);
    else
      offer(a + along * edge, edge_normal_[f][k]);
  }
  if (over_face) {
    const double above = (point - vertices_[t[0]]).dot(face_normal_[f]);
    offer(point - above * face_normal_[f], face_normal_[f]);
  }
}

}  // namespace spall
