// Meshes against the solids that they are of, and against sums over all their triangles.
// SPDX-License-Identifier: BSD-3-Clause
#include "scene/surface_mesh.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "scene/shape.hpp"
#include "scene/sphere_fill.hpp"
#include "spall/error.hpp"
#include "testing.hpp"

namespace spall {
namespace {

using Triangle = SurfaceMesh::Triangle;

struct Surface {
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
  SurfaceMesh mesh() const { return {vertices, triangles, "mesh"}; }
};

Surface cube(double width) {
  Surface s;
  for (int k = 0; k < 8; ++k)
    s.vertices.push_back(width * (Vec3(k & 1, k >> 1 & 1, k >> 2) - Vec3::Constant(0.5)));
  for (const std::array<int, 4>& q : {std::array{0, 2, 3, 1},
                                      {4, 5, 7, 6},
                                      {0, 1, 5, 4},
                                      {2, 6, 7, 3},
                                      {0, 4, 6, 2},
                                      {1, 3, 7, 5}}) {
    s.triangles.push_back({q[0], q[1], q[2]});
    s.triangles.push_back({q[0], q[2], q[3]});
  }
  return s;
}

/// A grid of m x n points that is closed in both directions.
Surface torus(double ring, double tube, int m, int n) {
  Surface s;
  for (int i = 0; i < m; ++i)
    for (int j = 0; j < n; ++j) {
      const double u = 2 * pi * i / m, v = 2 * pi * j / n, rho = ring + tube * std::cos(v);
      s.vertices.push_back({rho * std::cos(u), rho * std::sin(u), tube * std::sin(v)});
      const auto at = [&](int a, int b) { return a % m * n + b % n; };
      s.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      s.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return s;
}

/// An octahedron whose triangles are cut into four, `rounds` times, with vertices on the ellipsoid.
Surface ellipsoid(const Vec3& half, int rounds) {
  std::vector<std::array<Vec3, 3>> faces;
  for (int k = 0; k < 8; ++k) {
    const Vec3 x = (k & 1 ? 1 : -1) * Vec3::UnitX(), y = (k & 2 ? 1 : -1) * Vec3::UnitY(),
               z = (k & 4 ? 1 : -1) * Vec3::UnitZ();
    if (x.cross(y).dot(z) > 0)
      faces.push_back({x, y, z});
    else
      faces.push_back({x, z, y});
  }
  for (int round = 0; round < rounds; ++round) {
    std::vector<std::array<Vec3, 3>> finer;
    for (const auto& [a, b, c] : faces) {
      const Vec3 ab = (a + b).normalized(), bc = (b + c).normalized(), ca = (c + a).normalized();
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    faces = finer;
  }
  Surface s;
  const auto vertex = [&](const Vec3& unit) {
    const Vec3 x = half.cwiseProduct(unit);
    for (std::size_t k = 0; k < s.vertices.size(); ++k)
      if ((s.vertices[k] - x).norm() < 1e-9 * half.norm()) return static_cast<std::int32_t>(k);
    s.vertices.push_back(x);
    return static_cast<std::int32_t>(s.vertices.size() - 1);
  };
  for (const auto& [a, b, c] : faces) s.triangles.push_back({vertex(a), vertex(b), vertex(c)});
  return s;
}

/// How often the surface winds around a point: 1 inside, 0 outside; the sum of the triangles' solid
/// angles (van Oosterom & Strackee 1983) over 4 pi.
double winding(const SurfaceMesh& mesh, const Vec3& point) {
  double sum = 0;
  for (const Triangle& t : mesh.triangles()) {
    const Vec3 a = mesh.vertices()[t[0]] - point, b = mesh.vertices()[t[1]] - point,
               c = mesh.vertices()[t[2]] - point;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    sum += 2 * std::atan2(a.dot(b.cross(c)),
                          la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return sum / (4 * pi);
}

std::vector<Vec3> points_around(const SurfaceMesh& mesh, int count) {
  std::mt19937_64 engine(1);
  std::uniform_real_distribution<double> uniform(-1.3, 1.3);
  std::vector<Vec3> points;
  for (int k = 0; k < count; ++k)
    points.push_back(
        mesh.half_widths().cwiseProduct(Vec3(uniform(engine), uniform(engine), uniform(engine))));
  return points;
}

std::string complaint(const Surface& surface) {
  return complaint_of([&] { surface.mesh(); });
}

TEST(SurfaceMesh, volumes_are_those_of_the_solids) {
  EXPECT_NEAR(cube(2).mesh().volume(), 8, 1e-14);
  // Chords fall short of a round surface by the square of their length: twice as fine, a quarter.
  const auto torus_error = [](int n) {
    return 1 - torus(3, 1, 3 * n, n).mesh().volume() / (2 * pi * pi * 3);
  };
  EXPECT_NEAR(torus_error(20) / torus_error(40), 4, 0.05);
  EXPECT_LT(torus_error(80), 2e-3);
  const auto ball_error = [](int rounds) {
    return 1 - ellipsoid({3, 2, 1}, rounds).mesh().volume() / (8 * pi);
  };
  EXPECT_NEAR(ball_error(2) / ball_error(3), 4, 0.2);
  EXPECT_NEAR(ball_error(3) / ball_error(4), 4, 0.05);
}

/// How many of some points are inside, where the surface winds around them.
int count_inside(const SurfaceMesh& mesh) {
  int inside = 0;
  for (const Vec3& p : points_around(mesh, 4000)) {
    const bool is_inside = mesh.depth(p) > 0;
    EXPECT_NEAR(winding(mesh, p), is_inside ? 1 : 0, 1e-6) << p.transpose();
    inside += is_inside;
  }
  return inside;
}

TEST(SurfaceMesh, inside_is_where_the_surface_winds_around) {
  for (const Surface& surface : {cube(2), torus(3, 1, 24, 12), ellipsoid({3, 2, 1}, 2)})
    EXPECT_GT(count_inside(surface.mesh()), 400);
  // A flat octahedron fills less; at its edges faces turn by almost 180 degrees.
  EXPECT_GT(count_inside(ellipsoid({1, 1, 0.1}, 0).mesh()), 200);
}

TEST(SurfaceMesh, depth_in_a_cube_and_outside_is_the_distance_to_faces_edges_and_corners) {
  const SurfaceMesh mesh = cube(2).mesh();
  for (const Vec3& p : points_around(mesh, 4000)) {
    const Vec3 q = p.cwiseAbs() - Vec3::Ones();
    const double exact = q.maxCoeff() < 0 ? -q.maxCoeff() : -q.cwiseMax(0).norm();
    EXPECT_NEAR(mesh.depth(p), exact, 1e-14);
  }
  // On the planes that continue faces, and over edges: where rays graze.
  EXPECT_NEAR(mesh.depth({1, 0, 2}), -1, 1e-15);
  EXPECT_NEAR(mesh.depth({0, 0, 0}), 1, 1e-15);
  EXPECT_NEAR(mesh.depth({2, 2, 2}), -std::sqrt(3), 1e-15);
}

TEST(SurfaceMesh, depth_of_a_torus_nears_the_tubes) {
  const SurfaceMesh mesh = torus(3, 1, 120, 60).mesh();
  for (const Vec3& p : points_around(mesh, 2000)) {
    const double exact = 1 - std::hypot(std::hypot(p.x(), p.y()) - 3, p.z());
    EXPECT_NEAR(mesh.depth(p), exact, 4e-3);  // sagitta of the chords
  }
}

/// A tetrahedron with a fifth vertex on one of its edges, beside which lies a sliver.
Surface with_sliver(double t) {
  Surface s{{{9.8, 4.9, 9.2}, {-8.3, -2.4, 6.8}, {-1.9, -3.1, 0}, {-5.8, -4.4, 5.6}}, {}};
  s.vertices.push_back(s.vertices[0] + t * (s.vertices[1] - s.vertices[0]));
  s.triangles = {{0, 2, 1}, {0, 4, 3}, {4, 1, 3}, {0, 1, 4}, {0, 3, 2}, {1, 2, 3}};
  return s;
}

TEST(SurfaceMesh, slivers_change_no_distance) {
  const Surface plain{{{9.8, 4.9, 9.2}, {-8.3, -2.4, 6.8}, {-1.9, -3.1, 0}, {-5.8, -4.4, 5.6}},
                      {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
  const SurfaceMesh mesh = plain.mesh();
  int slivers = 0;
  for (int k = 1; k < 200; ++k) {
    const Surface surface = with_sliver(k / 200.0);
    if (!complaint(surface).empty()) continue;  // the fifth vertex is on the edge to the last bit
    ++slivers;
    const SurfaceMesh with = surface.mesh();
    for (const Vec3& p : points_around(mesh, 200))
      EXPECT_NEAR(std::abs(with.depth(p)), std::abs(mesh.depth(p)), 1e-9) << k;
  }
  EXPECT_GT(slivers, 50);
}

TEST(SurfaceMesh, one_inside_out_is_turned) {
  Surface surface = torus(3, 1, 24, 12);
  for (Triangle& t : surface.triangles) std::swap(t[0], t[1]);
  EXPECT_GT(surface.mesh().volume(), 0);
  EXPECT_GT(surface.mesh().depth({3, 0, 0}), 0.9);
}

TEST(SurfaceMesh, what_has_no_inside_is_refused) {
  Surface open = cube(2);
  open.triangles.pop_back();
  EXPECT_NE(complaint(open).find("mesh: the surface is open"), std::string::npos);
  Surface turned = cube(2);
  std::swap(turned.triangles[0][0], turned.triangles[0][1]);
  EXPECT_NE(complaint(turned).find("some of its faces are turned"), std::string::npos);
  Surface twice = cube(2);
  twice.triangles.push_back(twice.triangles[0]);
  EXPECT_NE(complaint(twice).find("run the same way"), std::string::npos);
  Surface touching = cube(2);  // two cubes that share an edge, which four triangles have
  for (const Vec3& v : cube(2).vertices) touching.vertices.push_back(v + Vec3(2, 2, 0));
  const auto second = [&](std::int32_t v) {  // its corners 0 and 4 are the first one's 3 and 7
    return v == 0 ? 3 : v == 4 ? 7 : v + 8;
  };
  for (const Triangle& t : cube(2).triangles)
    touching.triangles.push_back({second(t[0]), second(t[1]), second(t[2])});
  EXPECT_NE(complaint(touching).find("run the same way"), std::string::npos);
  Surface flat = cube(2);
  flat.triangles[3][0] = flat.triangles[3][1];
  EXPECT_NE(complaint(flat).find("no area"), std::string::npos);
}

TEST(SurfaceMesh, of_a_file_has_its_volume_around_the_origin) {
  const std::string box =
      "# a box, quads, kilometres\nv 1 1 1\nv 3 1 1\nv 3 2 1\nv 1 2 1\n"
      "v 1 1 4\nv 3 1 4\nv 3 2 4\nv 1 2 4\nvn 0 0 1\n"
      "f 4 3 2 1\nf 5//1 6//1 7//1 8//1\nf 1/1/1 2/2/1 6/3/1 5/4/1\n"
      "f -6 -5 -1 -2\nf 1 5 8 4\nf 2 3 7 6\n";
  const SurfaceMesh mesh = SurfaceMesh::from_obj(box, "x.obj", 1000);
  EXPECT_NEAR(mesh.volume(), 6e9, 1e-5);
  EXPECT_NEAR((mesh.half_widths() - Vec3(1000, 500, 1500)).norm(), 0, 1e-9);
  EXPECT_NEAR(mesh.depth({900, 0, 0}), 100, 1e-9);
  EXPECT_NEAR(mesh.depth({0, 0, 1700}), -200, 1e-9);

  for (const char* number :
       {"1e", "x", "", "1.5x", "nan", "inf", "1e60", "1e999", "1_0", "--1", "+-1"})
    EXPECT_EQ(complaint_of([&] {
                SurfaceMesh::from_obj(std::string("v 0 +1 -1e-3\r\n v\t2 3 ") + number, "x.obj", 1);
              }),
              "x.obj:2: three coordinates up to 1e+50 are wanted")
        << number;
  EXPECT_EQ(complaint_of([] { SurfaceMesh::from_obj("v 0 0 0\n\nf 1 1\n", "x.obj", 1); }),
            "x.obj:3: a face needs three corners");
  for (const char* corner : {"0", "-2", "1.5", "x", "1x", "99999999999999999999"})
    EXPECT_EQ(complaint_of([&] {
                SurfaceMesh::from_obj(std::string("v 0 0 0\nf 1 1 ") + corner, "x.obj", 1);
              }),
              fmt::format("x.obj:2: the face's corner \"{}\" is none of the 1 vertices above it",
                          corner));

  // Too small for a double, and a plus.
  EXPECT_EQ(complaint_of([] {
              SurfaceMesh::from_obj("v 1e-400 0 -1e-400\nv +1 0 0\nv 0 1 0\nf 1 2 3", "x.obj", 1);
            }).find("x.obj: the surface is open"),
            0);
  const std::string open = "v 0 0 0\nv 1 0 0\nf 1 2 7\n";
  EXPECT_EQ(complaint_of([&] { SurfaceMesh::from_obj(open, "x.obj", 1); }),
            "x.obj:3: the face's corner \"7\" is none of the 2 vertices above it");
}

// Spheres in a surface -----------------------------------------------------------------------

double filled_share(const SurfaceMesh& mesh, const std::vector<ShapeSphere>& spheres) {
  const BodyShape shape = make_shape("filled", spheres);
  const double r = spheres[0].radius / shape.spheres[0].radius;
  return shape.volume * r * r * r / mesh.volume();
}

TEST(SphereFill, lies_inside_hangs_together_and_fills_the_more_the_more_spheres_there_are) {
  const SurfaceMesh boulder = ellipsoid({2, std::sqrt(2.0), 1}, 4).mesh();
  for (const SurfaceMesh& mesh : {cube(2).mesh(), boulder, torus(2, 0.7, 40, 20).mesh()}) {
    double before = 0;
    for (int count : {1, 4, 12, 30}) {
      const auto spheres = fill_mesh(mesh, count);
      ASSERT_EQ(std::ssize(spheres), count);
      for (const ShapeSphere& s : spheres) {
        EXPECT_GT(s.radius, 0);
        EXPECT_LE(s.radius, spheres[0].radius);
        EXPECT_GE(mesh.depth(s.at), s.radius * (1 - 1e-7));
      }
      const double filled = filled_share(mesh, spheres);  // which throws where they fall apart
      EXPECT_GT(filled, before) << count;
      EXPECT_LT(filled, 1) << count;
      before = filled;
    }
    EXPECT_GT(before, 0.75);
  }
  // The ball in the cube touches it at the middles of its faces.
  EXPECT_NEAR(fill_mesh(cube(2).mesh(), 1)[0].radius, 1, 1e-3);
  // Of an ellipsoid as the rule for ellipsoids does it, or better.
  EXPECT_GT(filled_share(boulder, fill_mesh(boulder, 7)),
            0.98 * 4 * pi / 3 * 2 * std::sqrt(2.0) / boulder.volume() *
                filled_share(boulder, fill_ellipsoid({2, std::sqrt(2.0), 1}, 7)));
}

TEST(SphereFill, of_a_ball_is_the_ball_and_of_a_larger_one_larger) {
  const SurfaceMesh ball = ellipsoid(Vec3::Ones(), 5).mesh();
  EXPECT_GT(filled_share(ball, fill_mesh(ball, 1)), 0.99);
  const auto small = fill_mesh(cube(2).mesh(), 9), large = fill_mesh(cube(16).mesh(), 9);
  for (std::size_t k = 0; k < small.size(); ++k) {
    EXPECT_EQ(large[k].at, 8 * small[k].at);
    EXPECT_EQ(large[k].radius, 8 * small[k].radius);
  }
}

}  // namespace
}  // namespace spall
