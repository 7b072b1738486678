// Few bodies are at the surface of a piece: contacts are worked out one by one.
// SPDX-License-Identifier: BSD-3-Clause
#include "solid/contacts.hpp"

#include <algorithm>
#include <cmath>

#include "pairs/flight.hpp"

namespace spall {
namespace {

constexpr double stiffest = 0.8;  // of s eta: from there on the force grows linearly

double series(double a, double b) {
  return 2 * a * b / (a + b);
}

/// In the middle of the kick that comes.
Vec3 middle_velocity(const MotionRow& row, const ResponseRow& response) {
  return vector_of(row.motion) + Vec3(response.at[4][1], response.at[4][2], response.at[4][3]);
}

/// 1/s, how fast the body is stretched along the unit vector n.
double stretching(const ResponseRow& response, const Vec3& n) {
  const auto& at = response.at;
  return n[0] * n[0] * at[2][1] + n[1] * n[1] * at[2][2] + n[2] * n[2] * at[2][3] +
         2 * (n[1] * n[2] * at[3][0] + n[2] * n[0] * at[3][1] + n[0] * n[1] * at[3][2]);
}

/// m/s, what is left of a closing speed over the distance r with these gradients at its ends, and
/// never more.
double left_of(double closing, double a, double b, double r) {
  const double product = 4 * a * b, sum = a + b;
  return product > 0 ? closing + std::min(0.0, r / 2 * product / sum) : closing;
}

/// Calls `f(contact, push, x, r)` for each that pushes, x from i to j.
template <class F>
void for_each_pushing(const World& world, const std::vector<SolidLaw>& laws,
                      const std::vector<PieceContact>& contacts, const MotionRow* rows, F&& f) {
  const Bodies& bodies = world.bodies;
  for (const PieceContact& c : contacts) {
    const Vec3 x = vector_of(rows[c.j].place - rows[c.i].place);
    const double d = bodies.radius[c.i] + bodies.radius[c.j], r2 = x.squaredNorm();
    if (r2 >= d * d || r2 == 0) continue;
    const double smaller = 2 * std::min(bodies.radius[c.i], bodies.radius[c.j]);
    f(c, ContactPush(laws[bodies.material[c.i]], laws[bodies.material[c.j]], d, smaller), x,
      std::sqrt(r2));
  }
}

/// Calls `f(contact, push, face, r)` for each body that is pressed against a wall.
template <class F>
void for_each_pressed(const World& world, const std::vector<SolidLaw>& laws,
                      const std::vector<WallContact>& contacts, const MotionRow* rows, F&& f) {
  const Walls walls = world.walls();
  for (const WallContact& c : contacts) {
    const SolidLaw& law = laws[world.bodies.material[c.row]];
    const double d = 2 * world.bodies.radius[c.row];
    const Face face =
        face_of(walls, static_cast<std::size_t>(c.wall), vector_of(rows[c.row].place));
    const double r = face.height + d / 2;
    if (r < d) f(c, ContactPush(law, law, d, d), face, r);
  }
}

}  // namespace

ContactPush::ContactPush(const SolidLaw& a, const SolidLaw& b, double distance, double smaller)
    : distance_(distance),
      area_(1.5 * smaller * smaller / std::sqrt(2.0)),
      modulus_(series(a.bulk, b.bulk)),
      slope_((a.slope + b.slope) / 2),
      density_(series(a.density, b.density)),
      speed_(series(a.bulk_speed(), b.bulk_speed())) {}

namespace {

/// eta up to where its pressure grows as a shock's, and what is beyond.
struct Squeezed {
  double end, over, left;  ///< left: 1 - s end
  double slope;            ///< of the pressure by eta, of the modulus, at the end and beyond

  Squeezed(double eta, double s)
      : end(std::min(eta, stiffest / s)),
        over(eta - end),
        left(1 - s * end),
        slope((1 + s * end) / (left * left * left)) {}
};

}  // namespace

double ContactPush::force(double r) const {
  const auto [end, over, left, slope] = Squeezed(1 - r / distance_, slope_);
  return area_ * modulus_ * (end / (left * left) + slope * over);
}

double ContactPush::energy(double r) const {
  const auto [end, over, left, slope] = Squeezed(1 - r / distance_, slope_);
  return area_ * distance_ * modulus_ *
         ((std::log(left) + 1 / left - 1) / (slope_ * slope_) +
          over * (end / (left * left) + slope * over / 2));
}

double ContactPush::viscous(double closing) const {
  return closing > 0 ? area_ * density_ * closing * (speed_ + slope_ * closing) : 0;
}

SolidContacts find_contacts(const World& world, const std::vector<NearWindow>& windows,
                            double skin) {
  const Bodies& bodies = world.bodies;
  SolidContacts found;
  for_each_pair(windows, [&](std::size_t, std::size_t, std::size_t, Index i, Index j) {
    if (bodies.group[i] == bodies.group[j]) return;
    const double reach = neighbour_reach * (bodies.radius[i] + bodies.radius[j]) + skin;
    if ((bodies.position[j] - bodies.position[i]).squaredNorm() < reach * reach)
      found.pieces.push_back({i, j});
  });
  const Walls walls = world.walls();
  for (std::size_t w = 0; w < walls.size(); ++w)
    for (Index b = 0; b < bodies.owned; ++b)
      if (face_of(walls, w, bodies.position[b]).height < bodies.radius[b] + skin)
        found.walls.push_back({b, static_cast<std::int32_t>(w)});
  return found;
}

void push_by_contacts(World& world, const std::vector<SolidLaw>& laws,
                      const SolidContacts& contacts, double h, const MotionRow* rows,
                      const ResponseRow* responses, PushRow* impulses) {
  // Where both are slow they act for a stride, and rest together; else one acts in each part.
  const auto common = [&](double one, double other) { return one == other ? one : h / 2; };
  for_each_pushing(
      world, laws, contacts.pieces, rows,
      [&](const PieceContact& c, const ContactPush& push, const Vec3& x, double r) {
        const ResponseRow &i = responses[c.i], &j = responses[c.j];
        if (!i.acts() && !j.acts()) return;
        const double time = common(i.before(), j.before()) + common(i.after(), j.after());
        const Vec3 apart = middle_velocity(rows[c.j], j) - middle_velocity(rows[c.i], i);
        const Vec3 n = x / r;
        const double closing = -apart.dot(n);
        // Of one that does not act now the gradient is taken to be that of the other.
        const double of_i = stretching(i.acts() ? i : j, n);
        const double of_j = stretching(j.acts() ? j : i, n);
        const double viscous = push.viscous(left_of(closing, of_i, of_j, r));
        const double heat = time * viscous * closing / 2;
        const Vec3 impulse = time * (push.force(r) + viscous) * n;
        impulses[c.i] += half_row(-impulse, heat);
        impulses[c.j] += half_row(impulse, heat);
      });
  for_each_pressed(world, laws, contacts.walls, rows,
                   [&](const WallContact& c, const ContactPush& push, const Face& face, double r) {
                     const ResponseRow& response = responses[c.row];
                     const double time = response.time();
                     const double closing =
                         -middle_velocity(rows[c.row], response).dot(face.normal);
                     const double viscous = push.viscous(closing);
                     const Vec3 impulse = time * (push.force(r) + viscous) * face.normal;
                     impulses[c.row] += half_row(impulse, time * viscous * closing);
                     Reactions::at(world.reactions.of_walls, static_cast<std::size_t>(c.wall))
                         .add(vector_of(rows[c.row].place), -impulse);
                   });
}

double energy_of_contacts(const World& world, const std::vector<SolidLaw>& laws,
                          const SolidContacts& contacts, const MotionRow* rows) {
  double energy = 0;
  const Index owned = world.bodies.owned;
  for_each_pushing(world, laws, contacts.pieces, rows,
                   [&](const PieceContact& c, const ContactPush& push, const Vec3&, double r) {
                     energy += push.energy(r) * (c.i < owned && c.j < owned ? 1 : 0.5);
                   });
  for_each_pressed(world, laws, contacts.walls, rows,
                   [&](const WallContact&, const ContactPush& push, const Face&, double r) {
                     energy += push.energy(r);
                   });
  return energy;
}

}  // namespace spall
