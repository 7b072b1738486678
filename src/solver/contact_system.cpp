// The product and the residual; one exchange each way.
// SPDX-License-Identifier: BSD-3-Clause
#include "spall/solver/contact_system.hpp"

#include <algorithm>

namespace spall {

template <int dimension>
Rows<dimension> ContactSystem<dimension>::impulse_rows(const Impulses<dimension>& impulse) const {
  Rows<dimension> rows = zero_rows();
  add_contacts(contacts, impulse, rows.data());
  return rows;
}

template <int dimension>
Rows<dimension> ContactSystem<dimension>::velocity_rows(const Rows<dimension>& sums) const {
  Rows<dimension> velocity = zero_rows();
  for (Index b = 0; b < contacts.owned; ++b)
    row_velocity(contacts.inverse_mass[b], sums[b], velocity[b]);
  gather_begin(velocity);
  gather_end(velocity);
  return velocity;
}

template <int dimension>
Residual ContactSystem<dimension>::residual(const Impulses<dimension>& impulse,
                                            const Rows<dimension>& velocity) const {
  const ResidualSums local = with_friction(friction, [&](auto model) {
    return residual_sums<model()>(contacts, velocity.data(), impulse, centre, prox);
  });
  double sums[3] = {local.energy, local.energy_prox, local.square};
  ghosts.comm().sum(sums);
  return {std::sqrt(sums[0]) / scale, std::sqrt(sums[1]) / scale,
          std::sqrt(ghosts.comm().max(local.largest)),
          std::sqrt(sums[2] / std::max<double>(1, count))};
}

template struct ContactSystem<1>;
template struct ContactSystem<3>;

}  // namespace spall
