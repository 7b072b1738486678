// The product and the residual; one exchange each way.
// SPDX-License-Identifier: BSD-3-Clause
#include "solver/contact_system.hpp"

#include <algorithm>
#include <utility>

namespace spall {

template <class Real>
void multiply(const MatrixRows<Real>& matrix, Rows<3, Real>& rows) {
  using Half = HalfOf<Real>;
  const Index owned = matrix.contacts->owned();
  std::vector<Half> p(static_cast<std::size_t>(owned) + matrix.contacts->ghosts());
  for (Index c = 0; c < owned; ++c) p[c] = low_half(rows[c].at);
  matrix.contacts->gather(reinterpret_cast<double*>(p.data()), sizeof(Half) / sizeof(double));
  for (Index c = 0; c < owned; ++c) {
    Half u[3] = {};
    for (auto k = matrix.start[c]; k < matrix.start[c + 1]; ++k)
      for (int d = 0; d < 3; ++d) u[d] += matrix.blocks[k].column[d] * p[matrix.column[k]][d];
    const Half sum = u[0] + u[1] + u[2];
    rows[c].at = joined(p[c], sum);
  }
}
template void multiply(const MatrixRows<double>&, Rows<3, double>&);
template void multiply(const MatrixRows<float>&, Rows<3, float>&);

template <int dimension>
Rows<dimension, double> ContactSystem<dimension>::product(const DoubleImpulses& impulse) const {
  DoubleRows rows(contacts.rows);
  add_contacts(contacts, impulse, rows.data());
  complete_rows(contacts, rows);
  become_velocities(contacts, rows.data());
  rows.back() = Row<dimension, double>();
  gather_begin(ghosts, rows);
  gather_end(ghosts, rows);
  return rows;
}

template <int dimension>
Impulses<dimension, double> ContactSystem<dimension>::gradient_change(
    const DoubleRows& velocity) const {
  DoubleImpulses result(contacts.blocks.size());
  for (std::size_t at = 0; at < result.size(); ++at)
    scaled_velocity(contacts.blocks[at], velocity.data(), result[at].at);
  return result;
}

template <int dimension>
Impulses<dimension, double> ContactSystem<dimension>::gradient(const DoubleRows& velocity) const {
  DoubleImpulses result = gradient_change(velocity);
  for (std::size_t at = 0; at < result.size(); ++at)
    for (int d = 0; d < components<dimension>; ++d)
      result[at].at[d] += contacts.blocks[at].free_impulse[d];
  return result;
}

template <int dimension>
double ContactSystem<dimension>::metric_product(const DoubleImpulses& a,
                                                const DoubleImpulses& b) const {
  Lanes total{};
  for (std::size_t at = 0; at < a.size(); ++at)
    total += convert<double>(counted(contacts.blocks[at], contacts.owned)) *
             spall::metric_product(contacts.blocks[at], a[at].at, b[at].at);
  return ghosts.comm().sum(sum_of_lanes(total));
}

template <int dimension>
Residual ContactSystem<dimension>::residual(const DoubleImpulses& impulse,
                                            const DoubleRows& velocity) const {
  const ResidualSums local = with_friction(friction, [&](auto model) {
    return residual_sums<model()>(contacts, velocity.data(), impulse, centre, prox);
  });
  double sums[4] = {local.energy, local.energy_prox, local.square, local.norm2};
  double largest[2] = {local.largest, local.largest_prox};
  ghosts.comm().sum(sums);
  ghosts.comm().max(largest);
  return {.relative = std::sqrt(sums[0]) / scale,
          .relative_prox = std::sqrt(sums[1]) / scale,
          .max = std::sqrt(largest[0]) * units.velocity,
          .max_prox = std::sqrt(largest[1]) * units.velocity,
          .rms = std::sqrt(sums[2] / std::max<double>(1, count)) * units.velocity,
          .norm = std::sqrt(sums[3]) / scale};
}

template <int dimension>
void ContactSystem<dimension>::stay_near(const DoubleImpulses& impulse, double eps) {
  prox = eps;
  centre = impulse;
  for (std::size_t at = 0; at < centre.size(); ++at)
    for (int d = 0; d < components<dimension>; ++d)
      contacts.blocks[at].free_impulse[d] -= prox * centre[at].at[d];
  fresh.assign(impulse.size(), 0);
  for (std::size_t at = 0; at < impulse.size(); ++at)
    for (std::size_t l = 0; l < lane_count; ++l) {
      bool none = true;
      for (int d = 0; d < components<dimension>; ++d) none &= impulse[at].at[d][l] == 0;
      if (none || none_holds) fresh[at] |= 1u << l;
    }
}

template <int dimension>
void ContactSystem<dimension>::follow(const DoubleImpulses& iterate) {
  for (std::size_t at = 0; at < iterate.size(); ++at) {
    Lanes follows;
    for (std::size_t l = 0; l < lane_count; ++l) follows[l] = fresh[at] >> l & 1;
    for (int d = 0; d < components<dimension>; ++d) {
      const Lanes change = follows * (iterate[at].at[d] - centre[at].at[d]);
      centre[at].at[d] += change;
      contacts.blocks[at].free_impulse[d] -= prox * change;
    }
  }
}

template <int dimension>
Candidate<dimension> ContactSystem<dimension>::evaluate(DoubleImpulses impulse) const {
  DoubleRows velocity = product(impulse);
  const Residual left = residual(impulse, velocity);
  return {std::move(impulse), std::move(velocity), left};
}

template struct ContactSystem<1>;
template struct ContactSystem<3>;
template struct ContactSystem<levers>;

}  // namespace spall
