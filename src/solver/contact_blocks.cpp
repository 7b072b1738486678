// Packing and unpacking: the only place that knows which lane a contact is in.
// SPDX-License-Identifier: BSD-3-Clause
#include "spall/solver/contact_blocks.hpp"

namespace spall {
namespace {

std::size_t blocks_for(Index contacts) {
  return (static_cast<std::size_t>(contacts) + lanes - 1) / lanes;
}

/// Calls f(contact, block, lane) for every contact.
template <class F>
void for_each_place(const ContactProblem& problem, F&& f) {
  const std::size_t boundary_blocks = blocks_for(problem.boundary);
  for (Index c = 0; c < problem.contacts(); ++c) {
    const bool interior = c >= problem.boundary;
    const Index k = interior ? c - problem.boundary : c;
    f(c, (interior ? boundary_blocks : 0) + k / lanes, k % lanes);
  }
}

std::size_t total_blocks(const ContactProblem& problem) {
  return blocks_for(problem.boundary) + blocks_for(problem.contacts() - problem.boundary);
}

double inverse_or_zero(double a) {
  return a > 0 ? 1 / a : 0;
}

}  // namespace

template <int dimension>
ContactBlocks<dimension> pack(const ContactProblem& problem, Index owned) {
  ContactBlocks<dimension> packed;
  packed.owned = owned;
  packed.rows = static_cast<Index>(problem.inverse_mass.size()) + 1;
  packed.inverse_mass.assign(problem.inverse_mass.begin(), problem.inverse_mass.begin() + owned);
  packed.boundary = blocks_for(problem.boundary);

  const Index zero_row = packed.rows - 1;
  ContactBlock<dimension> empty{};
  for (int l = 0; l < lanes; ++l) empty.i[l] = empty.j[l] = zero_row;
  packed.blocks.assign(total_blocks(problem), empty);

  for_each_place(problem, [&](Index c, std::size_t at, int l) {
    ContactBlock<dimension>& block = packed.blocks[at];
    const Index i = problem.i[c], j = problem.j[c];
    const double a_n = problem.inverse_mass[i] + (j == ground ? 0 : problem.inverse_mass[j]);
    const Vec3 n = problem.normal[c], b = problem.free_velocity[c];
    block.i[l] = i;
    block.j[l] = j == ground ? zero_row : j;
    for (int d = 0; d < 3; ++d) block.normal[d][l] = n[d];
    block.cohesion[l] = problem.cohesive_impulse[c];
    block.a_n[l] = static_cast<float>(a_n);
    block.inverse_a_n[l] = static_cast<float>(inverse_or_zero(a_n));
    if constexpr (dimension == 1) {
      block.velocity[0][l] = block.inverse_a_n[l] * n.dot(b);
    } else {
      const double kappa = problem.kappa[c];
      const double a_t = (1 + 2.5 * kappa * kappa) * a_n;
      block.kappa[l] = kappa;
      block.friction[l] = problem.friction[c];
      block.a_t[l] = static_cast<float>(a_t);
      block.inverse_a_t[l] = static_cast<float>(inverse_or_zero(a_t));
      const Vec3 b_n = n.dot(b) * n;
      const Vec3 scaled =
          double(block.inverse_a_n[l]) * b_n + double(block.inverse_a_t[l]) * (b - b_n);
      for (int d = 0; d < 3; ++d) block.velocity[d][l] = scaled[d];
    }
  });
  return packed;
}

template <int dimension>
void add_centre(ContactBlocks<dimension>& contacts, const Impulses<dimension>& centre,
                double prox) {
  for (std::size_t at = 0; at < centre.size(); ++at)
    for (int d = 0; d < dimension; ++d) contacts.blocks[at].velocity[d] -= prox * centre[at].at[d];
}

template <int dimension>
Impulses<dimension> pack_impulses(const ContactProblem& problem, const std::vector<Vec3>& impulse) {
  Impulses<dimension> packed(total_blocks(problem));
  for_each_place(problem, [&](Index c, std::size_t at, int l) {
    if constexpr (dimension == 1)
      packed[at].at[0][l] = problem.normal[c].dot(impulse[c]);
    else
      for (int d = 0; d < 3; ++d) packed[at].at[d][l] = impulse[c][d];
  });
  return packed;
}

template <int dimension>
void unpack_impulses(const ContactProblem& problem, const Impulses<dimension>& packed,
                     std::vector<Vec3>& impulse) {
  for_each_place(problem, [&](Index c, std::size_t at, int l) {
    if constexpr (dimension == 1)
      impulse[c] = packed[at].at[0][l] * problem.normal[c];
    else
      for (int d = 0; d < 3; ++d) impulse[c][d] = packed[at].at[d][l];
  });
}

template ContactBlocks<1> pack<1>(const ContactProblem&, Index);
template ContactBlocks<3> pack<3>(const ContactProblem&, Index);
template void add_centre<1>(ContactBlocks<1>&, const Impulses<1>&, double);
template void add_centre<3>(ContactBlocks<3>&, const Impulses<3>&, double);
template Impulses<1> pack_impulses<1>(const ContactProblem&, const std::vector<Vec3>&);
template Impulses<3> pack_impulses<3>(const ContactProblem&, const std::vector<Vec3>&);
template void unpack_impulses<1>(const ContactProblem&, const Impulses<1>&, std::vector<Vec3>&);
template void unpack_impulses<3>(const ContactProblem&, const Impulses<3>&, std::vector<Vec3>&);

}  // namespace spall
