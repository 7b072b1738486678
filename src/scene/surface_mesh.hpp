// Closed surfaces of triangles, as shape models of asteroids are published.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>
#include <vector>

#include "spall/types.hpp"

namespace spall {

/// A closed surface: each edge belongs to two triangles that run through it in opposite directions,
/// and triangles run counter-clockwise seen from outside.
class SurfaceMesh {
 public:
  using Triangle = std::array<std::int32_t, 3>;

  /// Throws Error, which begins with `name`, on an index without a vertex, a triangle without an
  /// area, and an open or folded surface with one of its faulty edges. A surface that is inside
  /// out is turned.
  SurfaceMesh(std::vector<Vec3> vertices, std::vector<Triangle> triangles, const std::string& name);

  /// Of `v` and `f` lines of a Wavefront OBJ file's text, polygons as fans; lengths times `unit`,
  /// m. The center of the enclosed volume comes to lie in the origin.
  static SurfaceMesh from_obj(const std::string& text, const std::string& file, double unit);

  /// Distance to the surface, m, negative outside. The sign is that of the side on which `point`
  /// lies of the nearest triangle, edge or vertex, by its angle-weighted normal (Baerentzen &
  /// Aanaes 2005): exact for closed surfaces, with no ray that could graze an edge.
  double depth(const Vec3& point) const;

  double volume() const { return volume_; }          ///< m^3
  const Vec3& center() const { return center_; }     ///< of the enclosed volume, m
  const Vec3& half_widths() const { return half_; }  ///< of the smallest box about the origin
  const std::vector<Vec3>& vertices() const { return vertices_; }
  const std::vector<Triangle>& triangles() const { return triangles_; }

 private:
  /// A box around faces [first, last) in the order of the tree; its halves follow in the tree.
  struct Node {
    Vec3 low, high;
    std::int32_t first, last, right;  // right half's place; the left one is the next node
  };
  /// The corners of a triangle, beside those of its neighbours in the tree: a search would wait for
  /// each corner otherwise.
  struct Face {
    std::array<Vec3, 3> corner;
    std::int32_t triangle;
  };
  /// What a nearest point lies on: the inside of a triangle, its edge k or its corner k.
  struct Part {
    enum { inside, edge, corner } kind;
    std::int32_t triangle, k;
  };
  /// The nearest point found so far.
  struct Nearest {
    double distance2 = infinity;
    Vec3 point = Vec3::Zero();
    Part part{};
  };

  SurfaceMesh(std::vector<Vec3> vertices, std::vector<Triangle> triangles, const std::string& name,
              bool centred);
  void measure();
  void match_edges(const std::string& name);
  void weigh_normals(const std::string& name);
  std::int32_t build(std::int32_t first, std::int32_t last);
  void search(std::int32_t node, const Vec3& point, Nearest& nearest) const;
  static void visit(const Face& face, const Vec3& point, Nearest& nearest);
  Vec3 normal_of(const Part& part) const;

  std::vector<Vec3> vertices_;
  std::vector<Triangle> triangles_;
  std::vector<Triangle> beyond_;  // the triangle on the other side of edge k, from corner k on
  std::vector<Vec3> face_normal_, vertex_normal_;
  std::vector<Face> faces_;
  std::vector<Node> nodes_;
  double volume_ = 0;
  Vec3 center_ = Vec3::Zero(), half_ = Vec3::Zero();
};

}  // namespace spall
