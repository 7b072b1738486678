// The loops over contacts and bodies in which a solve spends its time.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "spall/solver/contact_blocks.hpp"
#include "spall/solver/projection.hpp"
#include "spall/solver/transfer.hpp"

namespace spall {

/// A run of blocks [first, last).
struct BlockRange {
  std::size_t first, last;
};

/// a . S b of eight contacts.
inline Pack metric_product(const ContactBlock<1>& block, const Pack* a, const Pack* b) {
  return widen(block.a_n) * a[0] * b[0];
}
inline Pack metric_product(const ContactBlock<3>& block, const Pack* a, const Pack* b) {
  const Pack* n = block.normal;
  const Pack a_n = a[0] * n[0] + a[1] * n[1] + a[2] * n[2];
  const Pack b_n = b[0] * n[0] + b[1] * n[1] + b[2] * n[2];
  const Pack ab = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  return widen(block.a_t) * (ab - a_n * b_n) + widen(block.a_n) * a_n * b_n;
}

/// S^-1 u of eight contacts from the rows' velocities, without the free velocity:
/// u = v_j - v_i - kappa (s_i + s_j) x n.
[[gnu::always_inline]] inline void scaled_velocity(const ContactBlock<1>& block,
                                                   const Row<1>* velocity, Pack* g) {
  Pack v[3];
  load_relative(velocity, block.i, block.j, v);
  const Pack* n = block.normal;
  g[0] = widen(block.inverse_a_n) * (v[0] * n[0] + v[1] * n[1] + v[2] * n[2]);
}
[[gnu::always_inline]] inline void scaled_velocity(const ContactBlock<3>& block,
                                                   const Row<3>* velocity, Pack* g) {
  Pack v[6];
  load_relative(velocity, block.i, block.j, v);
  const Pack* n = block.normal;
  const Pack* s = v + 3;
  const Pack u[3] = {v[0] - block.kappa * (s[1] * n[2] - s[2] * n[1]),
                     v[1] - block.kappa * (s[2] * n[0] - s[0] * n[2]),
                     v[2] - block.kappa * (s[0] * n[1] - s[1] * n[0])};
  const Pack inverse_a_t = widen(block.inverse_a_t);
  const Pack normal =
      (widen(block.inverse_a_n) - inverse_a_t) * (u[0] * n[0] + u[1] * n[1] + u[2] * n[2]);
  for (int d = 0; d < 3; ++d) g[d] = inverse_a_t * u[d] + normal * n[d];
}

/// Adds eight contacts' impulses to their bodies' rows, in impulse form.
[[gnu::always_inline]] inline void add_impulses(const ContactBlock<1>& block, const Pack* p,
                                                Row<1>* rows) {
  const Pack* n = block.normal;
  const Pack impulse[3] = {p[0] * n[0], p[0] * n[1], p[0] * n[2]};
  add_opposite(rows, block.i, block.j, impulse);
}
[[gnu::always_inline]] inline void add_impulses(const ContactBlock<3>& block, const Pack* p,
                                                Row<3>* rows) {
  const Pack* n = block.normal;
  const Pack impulse[6] = {p[0],
                           p[1],
                           p[2],
                           block.kappa * (n[1] * p[2] - n[2] * p[1]),
                           block.kappa * (n[2] * p[0] - n[0] * p[2]),
                           block.kappa * (n[0] * p[1] - n[1] * p[0])};
  add_opposite(rows, block.i, block.j, impulse);
}

/// The admissible impulse that replaces z, by the named friction model.
template <FrictionModel model>
[[gnu::always_inline]] inline void project(const ContactBlock<1>& block, const Pack* z, Pack* p) {
  p[0] = larger(z[0], -block.cohesion);
}
template <FrictionModel model>
[[gnu::always_inline]] inline void project(const ContactBlock<3>& block, const Pack* z, Pack* p) {
  const Pack* n = block.normal;
  const Pack z_n = z[0] * n[0] + z[1] * n[1] + z[2] * n[2];
  Pack t[3], length2{};
  for (int d = 0; d < 3; ++d) {
    t[d] = z[d] - z_n * n[d];
    length2 += t[d] * t[d];
  }
  const Pack length = square_root(length2);
  const Projected<Pack> to = model == FrictionModel::coulomb
                                 ? project_coulomb(z_n, length, block.friction, block.cohesion)
                                 : project_cone(z_n, length, block.friction, block.cohesion,
                                                widen(block.a_t) * widen(block.inverse_a_n));
  for (int d = 0; d < 3; ++d) p[d] = to.tangent_factor * t[d] + to.normal * n[d];
}

/// 1 where the contact counts on this rank: the owner of row i.
template <int dimension>
Pack counted(const ContactBlock<dimension>& block, Index owned) {
  Pack result;
  for (int l = 0; l < lanes; ++l) result[l] = block.i[l] < owned ? 1 : 0;
  return result;
}

/// One iteration's scalars: y = p + momentum (p - p_before);
/// z = keep y - step (S^-1 (D^T velocity + b) - eps p_c).
struct GradientStep {
  double momentum;
  double keep;
  double step;
};

/// Sums over counted contacts of one iteration.
struct StepSums {
  double length2 = 0;   ///< |p+ - y|_S^2
  double progress = 0;  ///< (p+ - y) . S (p+ - p): negative where momentum leads uphill
};

/// One projected-gradient step of the contacts in `range`: reads p, the iterate before it and the
/// velocities of y; writes the new iterate over the one before, and adds it to `impulse_rows`.
template <FrictionModel model, bool boundary, int dimension>
void step_contacts(const ContactBlocks<dimension>& contacts, BlockRange range,
                   const GradientStep& with, const Row<dimension>* velocity,
                   const ImpulseBlock<dimension>* iterate, ImpulseBlock<dimension>* before,
                   Row<dimension>* impulse_rows, StepSums& sums) {
  Pack length2{}, progress{};
  for (std::size_t at = range.first; at < range.last; ++at) {
    const ContactBlock<dimension>& block = contacts.blocks[at];
    const Pack* p = iterate[at].at;
    Pack y[dimension], g[dimension], z[dimension], next[dimension];
    scaled_velocity(block, velocity, g);
    for (int d = 0; d < dimension; ++d) {
      y[d] = p[d] + with.momentum * (p[d] - before[at].at[d]);
      z[d] = with.keep * y[d] - with.step * (g[d] + block.velocity[d]);
    }
    project<model>(block, z, next);
    add_impulses(block, next, impulse_rows);
    Pack from_y[dimension], from_p[dimension];
    for (int d = 0; d < dimension; ++d) {
      before[at].at[d] = next[d];
      from_y[d] = next[d] - y[d];
      from_p[d] = next[d] - p[d];
    }
    const Pack weight = boundary ? counted(block, contacts.owned) : Pack{} + 1.0;
    length2 += weight * metric_product(block, from_y, from_y);
    progress += weight * metric_product(block, from_y, from_p);
  }
  sums.length2 += sum(length2);
  sums.progress += sum(progress);
}

/// Adds all impulses of `range` to the rows.
template <int dimension>
void add_contacts(const ContactBlocks<dimension>& contacts, const Impulses<dimension>& p,
                  Row<dimension>* rows) {
  for (std::size_t at = 0; at < p.size(); ++at) add_impulses(contacts.blocks[at], p[at].at, rows);
}

/// Velocity of an owned row from its impulse form.
template <int dimension>
void row_velocity(double inverse_mass, const Row<dimension>& impulse, Row<dimension>& velocity) {
  for (int k = 0; k < Row<dimension>::width; ++k)
    velocity.at[k] = (k < 4 ? inverse_mass : -2.5 * inverse_mass) * impulse.at[k];
}

/// Velocities of y = p + momentum (p - p_before) for all owned rows, from the impulse forms of p
/// and of the iterate before, which is cleared for the next sum. Returns |V(p) - V(y_before)|_M^2,
/// with V(y_before) what `velocity` held: twice the kinetic energy of the difference.
template <int dimension>
double extrapolate_rows(const ContactBlocks<dimension>& contacts, double momentum,
                        const Row<dimension>* iterate, Row<dimension>* before,
                        Row<dimension>* velocity) {
  constexpr int width = Row<dimension>::width;
  double curvature[width] = {};
  for (Index b = 0; b < contacts.owned; ++b) {
    const double w = contacts.inverse_mass[b];
    const double mass = w > 0 ? 1 / w : 0;
    Row<dimension> now, next;
    row_velocity(w, iterate[b], now);
    row_velocity(w, before[b], next);
    for (int k = 0; k < width; ++k) {
      const double change = now.at[k] - velocity[b].at[k];
      curvature[k] += (k < 4 ? mass : 0.4 * mass) * change * change;
      velocity[b].at[k] = now.at[k] + momentum * (now.at[k] - next.at[k]);
      before[b].at[k] = 0;
    }
  }
  double total = 0;
  for (double c : curvature) total += c;
  return total;
}

/// What the natural map leaves, summed over counted contacts.
struct ResidualSums {
  double energy = 0;       ///< R^T S^-1 R of the problem as asked
  double energy_prox = 0;  ///< the same of the proximal problem
  double square = 0;       ///< |R|^2, m^2/s^2
  double largest = 0;      ///< |R|^2
};

/// d = p - P(p - g), g = S^-1 u~, with De Saxcé's mu |u_t| n for exact Coulomb: R = S d.
template <FrictionModel model>
void natural_map(const ContactBlock<1>& block, const Pack* p, const Pack* g, Pack* d) {
  const Pack z[1] = {p[0] - g[0]};
  project<model>(block, z, d);
  d[0] = p[0] - d[0];
}
template <FrictionModel model>
void natural_map(const ContactBlock<3>& block, const Pack* p, const Pack* g, Pack* d) {
  Pack de_saxce{};
  const Pack* n = block.normal;
  if constexpr (model == FrictionModel::coulomb) {
    const Pack g_n = g[0] * n[0] + g[1] * n[1] + g[2] * n[2];
    const Pack t[3] = {g[0] - g_n * n[0], g[1] - g_n * n[1], g[2] - g_n * n[2]};
    de_saxce = widen(block.a_t) * widen(block.inverse_a_n) * block.friction *
               square_root(t[0] * t[0] + t[1] * t[1] + t[2] * t[2]);
  }
  Pack z[3];
  for (int k = 0; k < 3; ++k) z[k] = p[k] - g[k] - de_saxce * n[k];
  project<FrictionModel::convex>(block, z, d);
  for (int k = 0; k < 3; ++k) d[k] = p[k] - d[k];
}

/// |S d|^2 of eight contacts.
inline Pack velocity_square(const ContactBlock<1>& block, const Pack* d) {
  const Pack r = widen(block.a_n) * d[0];
  return r * r;
}
inline Pack velocity_square(const ContactBlock<3>& block, const Pack* d) {
  const Pack* n = block.normal;
  const Pack a_n = widen(block.a_n), a_t = widen(block.a_t);
  const Pack d_n = d[0] * n[0] + d[1] * n[1] + d[2] * n[2];
  const Pack d2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
  return a_t * a_t * (d2 - d_n * d_n) + a_n * a_n * d_n * d_n;
}

/// Residuals of impulses p whose velocities (owned and ghost rows) are given; `centre` is p_c.
template <FrictionModel model, int dimension>
ResidualSums residual_sums(const ContactBlocks<dimension>& contacts, const Row<dimension>* velocity,
                           const Impulses<dimension>& iterate, const Impulses<dimension>& centre,
                           double prox) {
  Pack energy{}, energy_prox{}, square{}, most{};
  for (std::size_t at = 0; at < iterate.size(); ++at) {
    const ContactBlock<dimension>& block = contacts.blocks[at];
    const Pack* p = iterate[at].at;
    Pack g[dimension], g_prox[dimension], d[dimension];
    scaled_velocity(block, velocity, g);
    for (int k = 0; k < dimension; ++k) {
      g[k] += block.velocity[k];
      g_prox[k] = g[k] + prox * p[k];
      g[k] += prox * centre[at].at[k];
    }
    const Pack weight = counted(block, contacts.owned);
    natural_map<model>(block, p, g, d);
    energy += weight * metric_product(block, d, d);
    const Pack r2 = weight * velocity_square(block, d);
    square += r2;
    most = larger(most, r2);
    natural_map<model>(block, p, g_prox, d);
    energy_prox += weight * metric_product(block, d, d);
  }
  return {sum(energy), sum(energy_prox), sum(square), largest(most)};
}

}  // namespace spall
