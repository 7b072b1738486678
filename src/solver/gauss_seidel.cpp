// Projected Gauss-Seidel: boundary contacts all at once, then interior ones, one by one.
// SPDX-License-Identifier: BSD-3-Clause
//
// Boundary contacts start from velocities that both ranks hold alike. They are damped so that no
// body moves too far.
#include <algorithm>
#include <utility>

#include "solver/methods.hpp"

namespace spall {
namespace {

constexpr int sweeps_a_check = 10;  // fresh product and residual

/// One contact taken out of its block. In dimension 1 vectors are along the normal alone.
template <int dimension>
struct OneContact {
  const ContactBlock<dimension, double>& block;
  std::size_t l;

  Vec3 normal() const { return {block.normal[0][l], block.normal[1][l], block.normal[2][l]}; }

  Vec3 velocity(const Rows<dimension, double>& rows) const {
    const auto &i = rows[block.i[l]].at, &j = rows[block.j[l]].at;
    Vec3 u(j[0] - i[0], j[1] - i[1], j[2] - i[2]);
    if constexpr (dimension == 3) {
      const Vec3 n = normal(), s(i[4] + j[4], i[5] + j[5], i[6] + j[6]);
      u -= block.kappa[l] *
           Vec3(s[1] * n[2] - s[2] * n[1], s[2] * n[0] - s[0] * n[2], s[0] * n[1] - s[1] * n[0]);
    }
    return u;
  }

  /// The impulse that solves this contact alone, over-relaxed, from p at the rows' velocities.
  Vec3 relaxed(FrictionModel friction, double relaxation, const Vec3& p,
               const Rows<dimension, double>& rows) const {
    const Vec3 n = normal(), u = velocity(rows);
    const double s = block.cohesion[l], u_n = n.dot(u), p_n = n.dot(p);
    Vec3 free;
    for (int d = 0; d < 3; ++d)
      free[d] =
          dimension == 3 ? block.free_impulse[d % dimension][l] : block.free_impulse[0][l] * n[d];
    const double z_n = p_n - relaxation * (block.inverse_a_n[l] * u_n + n.dot(free));
    if constexpr (dimension == 1) {
      return larger(z_n, -s) * n;
    } else {
      const Vec3 g_t = block.inverse_a_t[l] * (u - u_n * n) + free - n.dot(free) * n;
      const Vec3 z_t = p - p_n * n - relaxation * g_t;
      const double mu = block.friction[l];
      const auto to =
          friction == FrictionModel::coulomb
              ? project_coulomb(z_n, z_t.norm(), mu, s)
              : project_cone(z_n, z_t.norm(), mu, s, double(block.a_t[l]) * block.inverse_a_n[l]);
      return to.normal * n + to.tangent_factor * z_t;
    }
  }

  /// Adds the change of the impulse to the velocities of row i or j.
  void push(const Vec3& change, double inverse_mass, Index row, double sign,
            Rows<dimension, double>& rows) const {
    auto& at = rows[row].at;
    for (int d = 0; d < 3; ++d) at[d] += sign * inverse_mass * change[d];
    if constexpr (dimension == 3) {
      const Vec3 n = normal();
      const double w = -1 / sphere_inertia * inverse_mass * block.kappa[l];
      at[4] += w * (n[1] * change[2] - n[2] * change[1]);
      at[5] += w * (n[2] * change[0] - n[0] * change[2]);
      at[6] += w * (n[0] * change[1] - n[1] * change[0]);
    }
  }

  void push(const Vec3& change, const ContactBlocks<dimension, double>& contacts,
            Rows<dimension, double>& rows) const {
    const Index i = block.i[l], j = block.j[l];
    if constexpr (dimension == 3)
      if (contacts.matrix) return push(change, contacts.matrix, i, contacts.owned, rows);
    if (i < contacts.owned) push(change, contacts.inverse_mass[i], i, -1, rows);
    if (j < contacts.owned) push(change, contacts.inverse_mass[j], j, 1, rows);
  }

  /// The same through a matrix, to owned contacts d: W_dc is the transpose of row c's block W_cd.
  void push(const Vec3& change, const MatrixRows<double>& matrix, Index c, Index owned,
            Rows<dimension, double>& rows) const {
    for (auto k = matrix.start[c]; k < matrix.start[c + 1]; ++k)
      if (matrix.column[k] < owned)
        for (int e = 0; e < 3; ++e) {
          const auto& column = matrix.blocks[k].column[e];
          rows[matrix.column[k]].at[e] -=
              column[0] * change[0] + column[1] * change[1] + column[2] * change[2];
        }
  }

  /// Spheres' interior contacts meet no other rank's. A matrix's contacts are all interior; with
  /// 1 + this for S they bound what those of other ranks, which move at once, may do.
  double outside(const ContactBlocks<dimension, double>& contacts) const {
    return contacts.matrix ? contacts.matrix.outside[block.i[l]] : 0;
  }

  Vec3 get(const Impulses<dimension, double>& p, std::size_t at) const {
    if constexpr (dimension == 1)
      return p[at].at[0][l] * normal();
    else
      return {p[at].at[0][l], p[at].at[1][l], p[at].at[2][l]};
  }
  void set(Impulses<dimension, double>& p, std::size_t at, const Vec3& value) const {
    if constexpr (dimension == 1)
      p[at].at[0][l] = normal().dot(value);
    else
      for (int d = 0; d < 3; ++d) p[at].at[d][l] = value[d];
  }
};

/// Calls f(contact, block) for every contact of the range, fill-ins left out.
template <int dimension, class F>
void for_each_contact(const ContactBlocks<dimension, double>& contacts, BlockRange range, F&& f) {
  for (std::size_t at = range.first; at < range.last; ++at)
    for (std::size_t l = 0; l < lane_count; ++l)
      if (contacts.blocks[at].i[l] != contacts.rows - 1)
        f(OneContact<dimension>{contacts.blocks[at], l}, at);
}

/// Boundary contacts of every row, owned and ghosts: splitting a body's mass over as many makes
/// contacts that move at once safe (mass splitting, Tonge et al. 2012).
template <int dimension>
std::vector<double> boundary_degrees(const ContactSystem<dimension>& system) {
  const auto& contacts = system.contacts;
  std::vector<double> degree(contacts.rows, 0);
  for_each_contact(contacts, system.boundary(), [&](const auto& contact, std::size_t) {
    ++degree[contact.block.i[contact.l]];
    ++degree[contact.block.j[contact.l]];
  });
  system.ghosts.gather(degree.data(), 1);
  return degree;
}

}  // namespace

template <int dimension>
Candidate<dimension> gauss_seidel(const ContactSystem<dimension>& system,
                                  const MethodSettings& settings, Candidate<dimension> start,
                                  SolverReport& report) {
  const auto& contacts = system.contacts;
  const std::vector<double> degree = boundary_degrees(system);
  Candidate<dimension> best = std::move(start);
  Impulses<dimension, double> p = best.impulse;
  Rows<dimension, double> velocity = best.velocity;
  std::vector<Vec3> changes;

  while (!used_up(settings, report) && !met(best.residual, system, settings)) {
    changes.clear();
    for_each_contact(contacts, system.boundary(), [&](const auto& contact, std::size_t at) {
      const double split =
          std::max(degree[contact.block.i[contact.l]], degree[contact.block.j[contact.l]]);
      const Vec3 old = contact.get(p, at);
      const Vec3 now = contact.relaxed(system.friction, 1 / split, old, velocity);
      contact.set(p, at, now);
      changes.push_back(now - old);
    });
    std::size_t next = 0;
    for_each_contact(contacts, system.boundary(), [&](const auto& contact, std::size_t) {
      contact.push(changes[next++], contacts, velocity);
    });
    for_each_contact(contacts, system.interior(), [&](const auto& contact, std::size_t at) {
      const Vec3 old = contact.get(p, at);
      const double relaxation = settings.relaxation / (1 + contact.outside(contacts));
      const Vec3 now = contact.relaxed(system.friction, relaxation, old, velocity);
      contact.set(p, at, now);
      contact.push(now - old, contacts, velocity);
    });
    ++report.iterations;
    ++report.products;

    if (report.iterations % sweeps_a_check == 0 || used_up(settings, report)) {
      Candidate<dimension> now = system.evaluate(p);
      ++report.products;
      velocity = now.velocity;
      if (now.residual.relative < best.residual.relative) best = std::move(now);
    } else if (contacts.matrix && system.ghosts.comm().size > 1) {
      velocity = system.product(p);
      ++report.products;
    } else {
      gather_begin(system.ghosts, velocity);
      gather_end(system.ghosts, velocity);
    }
  }
  return best;
}

template Candidate<1> gauss_seidel(const ContactSystem<1>&, const MethodSettings&, Candidate<1>,
                                   SolverReport&);
template Candidate<3> gauss_seidel(const ContactSystem<3>&, const MethodSettings&, Candidate<3>,
                                   SolverReport&);

}  // namespace spall
