// The product and the residual; one exchange each way.
// SPDX-License-Identifier: BSD-3-Clause
#include "spall/solver/contact_system.hpp"

#include <algorithm>
#include <utility>

namespace spall {

template <int dimension>
Rows<dimension, double> ContactSystem<dimension>::impulse_rows(
    const DoubleImpulses& impulse) const {
  DoubleRows rows(contacts.rows);
  add_contacts(contacts, impulse, rows.data());
  return rows;
}

template <int dimension>
Rows<dimension, double> ContactSystem<dimension>::velocity_rows(const DoubleRows& sums) const {
  DoubleRows velocity(contacts.rows);
  for (Index b = 0; b < contacts.owned; ++b)
    velocity[b] = row_velocity(contacts.inverse_mass[b], sums[b]);
  gather_begin(ghosts, velocity);
  gather_end(ghosts, velocity);
  return velocity;
}

template <int dimension>
Residual ContactSystem<dimension>::residual(const DoubleImpulses& impulse,
                                            const DoubleRows& velocity) const {
  const ResidualSums local = with_friction(friction, [&](auto model) {
    return residual_sums<model()>(contacts, velocity.data(), impulse, centre, prox);
  });
  double sums[4] = {local.energy, local.energy_prox, local.square, local.norm2};
  ghosts.comm().sum(sums);
  return {.relative = std::sqrt(sums[0]) / scale,
          .relative_prox = std::sqrt(sums[1]) / scale,
          .max = std::sqrt(ghosts.comm().max(local.largest)) * units.velocity,
          .rms = std::sqrt(sums[2] / std::max<double>(1, count)) * units.velocity,
          .norm = std::sqrt(sums[3]) / scale};
}

template <int dimension>
Candidate<dimension> ContactSystem<dimension>::evaluate(DoubleImpulses impulse) const {
  DoubleRows velocity = velocity_rows(impulse_rows(impulse));
  const Residual left = residual(impulse, velocity);
  return {std::move(impulse), std::move(velocity), left};
}

template struct ContactSystem<1>;
template struct ContactSystem<3>;

}  // namespace spall
