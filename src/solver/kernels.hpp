// The loops over contacts and bodies in which a solve spends its time.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

#include "solver/contact_blocks.hpp"
#include "solver/projection.hpp"
#include "solver/transfer.hpp"

namespace spall {

/// A run of blocks [first, last).
struct BlockRange {
  std::size_t first, last;
};

template <class P>
void cross(const P* a, const P* b, P* out) {
  for (int d = 0; d < 3; ++d) {
    const int e = (d + 1) % 3, f = (d + 2) % 3;
    out[d] = a[e] * b[f] - a[f] * b[e];
  }
}

template <class P>
P dot(const P* a, const P* b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// a . S b of eight contacts.
template <class Real>
LanesOf<Real> metric_product(const ContactBlock<1, Real>& block, const LanesOf<Real>* a,
                             const LanesOf<Real>* b) {
  return convert<Real>(block.a_n) * a[0] * b[0];
}
template <class Real>
LanesOf<Real> metric_product(const ContactBlock<3, Real>& block, const LanesOf<Real>* a,
                             const LanesOf<Real>* b) {
  const LanesOf<Real> normal = dot(a, block.normal) * dot(b, block.normal);
  return convert<Real>(block.a_t) * (dot(a, b) - normal) + convert<Real>(block.a_n) * normal;
}

/// S^-1 u of eight contacts from the rows' velocities, without the free velocity:
/// u = v_j - v_i - kappa (s_i + s_j) x n.
template <class Real>
[[gnu::always_inline]] inline void scaled_velocity(const ContactBlock<1, Real>& block,
                                                   const Row<1, Real>* velocity, LanesOf<Real>* g) {
  LanesOf<Real> v[3];
  load_relative(velocity, block.i, block.j, v);
  g[0] = convert<Real>(block.inverse_a_n) * dot(v, block.normal);
}
template <class Real>
[[gnu::always_inline]] inline void scaled_velocity(const ContactBlock<3, Real>& block,
                                                   const Row<3, Real>* velocity, LanesOf<Real>* g) {
  using P = LanesOf<Real>;
  P v[6];
  load_relative(velocity, block.i, block.j, v);
  const P* n = block.normal;
  const P* s = v + 3;
  const P u[3] = {v[0] - block.kappa * (s[1] * n[2] - s[2] * n[1]),
                  v[1] - block.kappa * (s[2] * n[0] - s[0] * n[2]),
                  v[2] - block.kappa * (s[0] * n[1] - s[1] * n[0])};
  const P inverse_a_t = convert<Real>(block.inverse_a_t);
  const P normal = (convert<Real>(block.inverse_a_n) - inverse_a_t) * dot(u, n);
  for (int d = 0; d < 3; ++d) g[d] = inverse_a_t * u[d] + normal * n[d];
}

/// The same with lever arms: u = v_j - v_i + s_j x a_j - s_i x a_i.
template <class Real>
[[gnu::always_inline]] inline void scaled_velocity(const ContactBlock<levers, Real>& block,
                                                   const Row<levers, Real>* velocity,
                                                   LanesOf<Real>* g) {
  using P = LanesOf<Real>;
  P v[9], of_i[3], of_j[3], u[3];
  load_both(velocity, block.i, block.j, v);
  cross(v + 3, block.arm_i, of_i);
  cross(v + 6, block.arm_j, of_j);
  for (int d = 0; d < 3; ++d) u[d] = v[d] + of_j[d] - of_i[d];
  const P* n = block.normal;
  const P inverse_a_t = convert<Real>(block.inverse_a_t);
  const P normal = (convert<Real>(block.inverse_a_n) - inverse_a_t) * dot(u, n);
  for (int d = 0; d < 3; ++d) g[d] = inverse_a_t * u[d] + normal * n[d];
}

/// Adds eight contacts' impulses to their bodies' rows, in impulse form.
template <class Real>
[[gnu::always_inline]] inline void add_impulses(const ContactBlock<1, Real>& block,
                                                const LanesOf<Real>* p, Row<1, Real>* rows) {
  const LanesOf<Real>* n = block.normal;
  const LanesOf<Real> impulse[3] = {p[0] * n[0], p[0] * n[1], p[0] * n[2]};
  add_opposite(rows, block.i, block.j, impulse);
}
template <class Real>
[[gnu::always_inline]] inline void add_impulses(const ContactBlock<3, Real>& block,
                                                const LanesOf<Real>* p, Row<3, Real>* rows) {
  const LanesOf<Real>* n = block.normal;
  const LanesOf<Real> impulse[6] = {p[0],
                                    p[1],
                                    p[2],
                                    block.kappa * (n[1] * p[2] - n[2] * p[1]),
                                    block.kappa * (n[2] * p[0] - n[0] * p[2]),
                                    block.kappa * (n[0] * p[1] - n[1] * p[0])};
  add_opposite(rows, block.i, block.j, impulse);
}

template <class Real>
[[gnu::always_inline]] inline void add_impulses(const ContactBlock<levers, Real>& block,
                                                const LanesOf<Real>* p, Row<levers, Real>* rows) {
  LanesOf<Real> both[9] = {p[0], p[1], p[2]};
  cross(block.arm_i, p, both + 3);
  cross(block.arm_j, p, both + 6);
  add_both(rows, block.i, block.j, both);
}

/// The admissible impulse that replaces z, by the named friction model.
template <FrictionModel model, class Real>
void project(const ContactBlock<1, Real>& block, const LanesOf<Real>* z, LanesOf<Real>* p) {
  p[0] = larger(z[0], -block.cohesion);
}
template <FrictionModel model, class Real>
[[gnu::always_inline]] inline void project(const ContactBlock<3, Real>& block,
                                           const LanesOf<Real>* z, LanesOf<Real>* p) {
  using P = LanesOf<Real>;
  const P* n = block.normal;
  const P z_n = dot(z, n);
  const P t[3] = {z[0] - z_n * n[0], z[1] - z_n * n[1], z[2] - z_n * n[2]};
  const P length = square_root(dot(t, t));
  const Projected<P> to =
      model == FrictionModel::coulomb
          ? project_coulomb(z_n, length, block.friction, block.cohesion)
          : project_cone(z_n, length, block.friction, block.cohesion,
                         convert<Real>(block.a_t) * convert<Real>(block.inverse_a_n));
  for (int d = 0; d < 3; ++d) p[d] = to.tangent_factor * t[d] + to.normal * n[d];
}

/// 1 where the contact counts on this rank: the owner of row i.
template <class Block>
FloatLanes counted(const Block& block, Index owned) {
  FloatLanes result;
  for (std::size_t l = 0; l < lane_count; ++l) result[l] = block.i[l] < owned ? 1 : 0;
  return result;
}

/// One iteration's scalars: y = p + momentum (p - p_before);
/// z = keep y - step (S^-1 (D^T velocity + b) - eps p_c).
template <class Real>
struct GradientStep {
  Real momentum;
  Real keep;
  Real step;
};

/// Sums over counted contacts of one iteration.
struct StepSums {
  double length2 = 0;   ///< |p+ - y|_S^2
  double progress = 0;  ///< (p+ - y) . S (p+ - p): negative where momentum leads uphill
};

/// Blocks treated in three short loops (velocities, projections, sums) rather than one long one: a
/// block's chain of dependent operations is longer than what a core can look ahead, so that one
/// block would wait for the other.
inline constexpr std::size_t batch = 8;

/// One projected-gradient step of the contacts in `range`: reads p, the iterate before it and the
/// velocities of y; writes the new iterate over the one before, and adds it to `impulse_rows`.
template <FrictionModel model, bool boundary, int dimension, class Real>
void step_contacts(const ContactBlocks<dimension, Real>& contacts, BlockRange range,
                   const GradientStep<Real>& with, const Row<dimension, Real>* velocity,
                   const ImpulseBlock<dimension, Real>* iterate,
                   ImpulseBlock<dimension, Real>* before, Row<dimension, Real>* impulse_rows,
                   StepSums& sums) {
  using P = LanesOf<Real>;
  const ContactBlock<dimension, Real>* blocks = contacts.blocks.data();
  Lanes length2{}, progress{};
  for (std::size_t first = range.first; first < range.last; first += batch) {
    const std::size_t last = std::min(first + batch, range.last);
    P g[batch][components<dimension>];
    for (std::size_t at = first; at < last; ++at)
      scaled_velocity(blocks[at], velocity, g[at - first]);
    P batch_length2{}, batch_progress{};
    for (std::size_t at = first; at < last; ++at) {
      const ContactBlock<dimension, Real>& block = blocks[at];
      P y[components<dimension>], z[components<dimension>], next[components<dimension>],
          from_y[components<dimension>], from_p[components<dimension>];
      for (int d = 0; d < components<dimension>; ++d) {
        const P p = iterate[at].at[d];
        y[d] = p + with.momentum * (p - before[at].at[d]);
        z[d] = with.keep * y[d] - with.step * (g[at - first][d] + block.free_impulse[d]);
      }
      project<model>(block, z, next);
      for (int d = 0; d < components<dimension>; ++d) {
        before[at].at[d] = next[d];
        from_y[d] = next[d] - y[d];
        from_p[d] = next[d] - iterate[at].at[d];
      }
      P y2 = metric_product(block, from_y, from_y), yp = metric_product(block, from_y, from_p);
      if (boundary) {
        const P weight = convert<Real>(counted(block, contacts.owned));
        y2 *= weight;
        yp *= weight;
      }
      batch_length2 += y2;
      batch_progress += yp;
    }
    for (std::size_t at = first; at < last; ++at)
      add_impulses(blocks[at], before[at].at, impulse_rows);
    length2 += convert<double>(batch_length2);
    progress += convert<double>(batch_progress);
  }
  sums.length2 += sum_of_lanes(length2);
  sums.progress += sum_of_lanes(progress);
}

/// Adds all impulses to the rows.
template <int dimension, class Real>
void add_contacts(const ContactBlocks<dimension, Real>& contacts,
                  const Impulses<dimension, Real>& p, Row<dimension, Real>* rows) {
  for (std::size_t at = 0; at < p.size(); ++at) add_impulses(contacts.blocks[at], p[at].at, rows);
}

/// [1 1 1 1 | c c c c], cut to the row's width.
template <int dimension, class Real>
constexpr typename Row<dimension, Real>::Vector halves(Real c) {
  if constexpr (dimension == 1)
    return HalfOf<Real>{1, 1, 1, 1};
  else
    return LanesOf<Real>{1, 1, 1, 1, c, c, c, c};
}

/// Velocity of an owned row from its impulse form.
template <int dimension, class Real>
Row<dimension, Real> row_velocity(Real inverse_mass, const Row<dimension, Real>& impulse) {
  return {inverse_mass * halves<dimension, Real>(-1 / sphere_inertia) * impulse.at};
}

template <class Real>
LanesOf<Real> operator*(const RowMatrix<Real>& m, const LanesOf<Real>& row) {
  const auto z_x_y = [](const LanesOf<Real>& v) { return shuffle<0, 1, 2, 3, 6, 4, 5, 7>(v, v); };
  return m.diagonal * row + m.beside * shuffle<0, 1, 2, 3, 5, 6, 4, 7>(row, row) +
         z_x_y(m.beside) * z_x_y(row);
}

/// Rows of a problem with a matrix: a contact enters its own row with -p, and reads -(row). In
/// impulse form [-p 0 | -W p 0] once the matrix was applied, in velocity form the halves exchanged.
template <class Real>
Row<3, Real> exchange_halves(const Row<3, Real>& row) {
  return {shuffle<4, 5, 6, 7, 0, 1, 2, 3>(row.at, row.at)};
}

/// Owned rows from impulse to velocity form.
template <int dimension, class Real>
void become_velocities(const ContactBlocks<dimension, Real>& contacts, Row<dimension, Real>* rows) {
  if constexpr (dimension == 3)
    if (contacts.matrix) {
      std::transform(rows, rows + contacts.owned, rows, exchange_halves<Real>);
      return;
    }
  for (Index b = 0; b < contacts.owned; ++b)
    if constexpr (dimension == levers)
      rows[b] = {contacts.turning[b].factor * rows[b].at};
    else
      rows[b] = row_velocity(contacts.inverse_mass[b], rows[b]);
}

/// The loop of `extrapolate_rows`: `of(b, row)` is a row's velocity form, `energy(b, change)` twice
/// the energy of a change of it, to be summed over its numbers.
template <int dimension, class Real, class Velocity, class Energy>
[[gnu::always_inline]] inline double extrapolate(Index owned, Real momentum,
                                                 const Row<dimension, Real>* iterate,
                                                 Row<dimension, Real>* before,
                                                 Row<dimension, Real>* velocity, Velocity&& of,
                                                 Energy&& energy) {
  using Vector = typename Row<dimension, Real>::Vector;
  Row<dimension, double> curvature{};
  for (Index b = 0; b < owned; ++b) {
    const Vector now = of(b, iterate[b]).at;
    const Vector part = energy(b, now - velocity[b].at);
    curvature.at += convert<double>(part);
    velocity[b].at = now + momentum * (now - of(b, before[b]).at);
    before[b] = Row<dimension, Real>();
  }
  double total = 0;
  for (int k = 0; k < Row<dimension, Real>::width; ++k) total += curvature.at[k];
  return total;
}

/// Velocities of y = p + momentum (p - p_before) for all owned rows, from the impulse forms of p
/// and of the iterate before, which is cleared for the next sum. Returns (p - y_before) . N
/// (p - y_before) with V(y_before) what `velocity` held: twice the kinetic energy of V(p) - V(y).
template <int dimension, class Real>
double extrapolate_rows(const ContactBlocks<dimension, Real>& contacts, Real momentum,
                        const Row<dimension, Real>* iterate, Row<dimension, Real>* before,
                        Row<dimension, Real>* velocity) {
  using Vector = typename Row<dimension, Real>::Vector;
  if constexpr (dimension == 3)
    if (contacts.matrix)
      return extrapolate(
          contacts.owned, momentum, iterate, before, velocity,
          [](Index, const Row<3, Real>& row) { return exchange_halves(row); },
          [](Index, const Vector& change) -> Vector {  // [-W p | -p] of the change
            return halves<3, Real>(0) * change * exchange_halves(Row<3, Real>{change}).at;
          });
  if constexpr (dimension == levers) {
    const Turning<Real>* turning = contacts.turning.data();
    return extrapolate(
        contacts.owned, momentum, iterate, before, velocity,
        [=](Index b, const Row<levers, Real>& row) {
          return Row<levers, Real>{turning[b].factor * row.at};
        },
        [=](Index b, const Vector& change) -> Vector {
          return change * (turning[b].inverse * change);
        });
  } else {
    const Real* w = contacts.inverse_mass.data();
    return extrapolate(
        contacts.owned, momentum, iterate, before, velocity,
        [w](Index b, const Row<dimension, Real>& row) { return row_velocity(w[b], row); },
        [w](Index b, const Vector& change) -> Vector {
          const Real mass = w[b] > 0 ? 1 / w[b] : 0;
          return mass * halves<dimension, Real>(sphere_inertia) * change * change;
        });
  }
}

/// What the natural map leaves, summed over counted contacts, in packed units.
struct ResidualSums {
  double energy = 0;       ///< R^T S^-1 R of the problem as asked
  double energy_prox = 0;  ///< the same of the proximal problem
  double square = 0;       ///< |R|^2
  double norm2 = 0;        ///< |p|_S^2
  double largest = 0;      ///< |R|^2
  double largest_prox = 0;
};

/// d = p - P(p - g), g = S^-1 u~, with De Saxcé's mu |u_t| n for exact Coulomb: R = S d.
template <FrictionModel model>
inline void natural_map(const ContactBlock<1, double>& block, const Lanes* p, const Lanes* g,
                        Lanes* d) {
  const Lanes z[1] = {p[0] - g[0]};
  project<model>(block, z, d);
  d[0] = p[0] - d[0];
}
template <FrictionModel model>
inline void natural_map(const ContactBlock<3, double>& block, const Lanes* p, const Lanes* g,
                        Lanes* d) {
  const Lanes* n = block.normal;
  Lanes de_saxce{};
  if constexpr (model == FrictionModel::coulomb) {
    const Lanes g_n = dot(g, n);
    const Lanes t[3] = {g[0] - g_n * n[0], g[1] - g_n * n[1], g[2] - g_n * n[2]};
    const Lanes theta2 = convert<double>(block.a_t) * convert<double>(block.inverse_a_n);
    de_saxce = theta2 * block.friction * square_root(dot(t, t));
  }
  Lanes z[3];
  for (int k = 0; k < 3; ++k) z[k] = p[k] - g[k] - de_saxce * n[k];
  project<FrictionModel::convex>(block, z, d);
  for (int k = 0; k < 3; ++k) d[k] = p[k] - d[k];
}

/// |S d|^2 of eight contacts.
inline Lanes velocity_square(const ContactBlock<1, double>& block, const Lanes* d) {
  const Lanes r = convert<double>(block.a_n) * d[0];
  return r * r;
}
inline Lanes velocity_square(const ContactBlock<3, double>& block, const Lanes* d) {
  const Lanes a_n = convert<double>(block.a_n), a_t = convert<double>(block.a_t);
  const Lanes d_n = dot(d, block.normal);
  return a_t * a_t * (dot(d, d) - d_n * d_n) + a_n * a_n * d_n * d_n;
}

/// Residuals of impulses p whose velocities (owned and ghost rows) are given; `centre` is p_c.
template <FrictionModel model, int dimension>
ResidualSums residual_sums(const ContactBlocks<dimension, double>& contacts,
                           const Row<dimension, double>* velocity,
                           const Impulses<dimension, double>& iterate,
                           const Impulses<dimension, double>& centre, double prox) {
  Lanes energy{}, energy_prox{}, square{}, norm2{}, most{}, most_prox{};
  for (std::size_t at = 0; at < iterate.size(); ++at) {
    const ContactBlock<dimension, double>& block = contacts.blocks[at];
    const Lanes* p = iterate[at].at;
    Lanes g[components<dimension>], g_prox[components<dimension>], d[components<dimension>];
    scaled_velocity(block, velocity, g);
    for (int k = 0; k < components<dimension>; ++k) {
      g[k] += block.free_impulse[k];
      g_prox[k] = g[k] + prox * p[k];
      g[k] += prox * centre[at].at[k];
    }
    const Lanes weight = convert<double>(counted(block, contacts.owned));
    natural_map<model>(block, p, g, d);
    energy += weight * metric_product(block, d, d);
    const Lanes r2 = weight * velocity_square(block, d);
    square += r2;
    most = larger(most, r2);
    if (prox > 0) natural_map<model>(block, p, g_prox, d);
    energy_prox += weight * metric_product(block, d, d);
    most_prox = larger(most_prox, weight * velocity_square(block, d));
    norm2 += weight * metric_product(block, p, p);
  }
  return {sum_of_lanes(energy), sum_of_lanes(energy_prox), sum_of_lanes(square),
          sum_of_lanes(norm2),  largest_lane(most),        largest_lane(most_prox)};
}

}  // namespace spall
