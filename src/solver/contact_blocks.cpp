// Packing and unpacking: the only place that knows which lane a contact is in.
// SPDX-License-Identifier: BSD-3-Clause
#include "solver/contact_blocks.hpp"

#include <algorithm>
#include <array>

namespace spall {
namespace {

std::size_t blocks_for(Index contacts) {
  return (static_cast<std::size_t>(contacts) + lane_count - 1) / lane_count;
}

std::size_t total_blocks(const ContactProblem& problem) {
  return blocks_for(problem.boundary) + blocks_for(problem.contacts() - problem.boundary);
}

/// Calls f(contact, block, lane) for every contact.
template <class F>
void for_each_place(const ContactProblem& problem, F&& f) {
  const std::size_t boundary_blocks = blocks_for(problem.boundary);
  for (Index c = 0; c < problem.contacts(); ++c) {
    const bool interior = c >= problem.boundary;
    const Index k = interior ? c - problem.boundary : c;
    f(c, (interior ? boundary_blocks : 0) + k / lane_count, k % lane_count);
  }
}

/// 1/kg, about how much the contact gives way: 0 where neither of its bodies ever moves.
double mobility(const ContactProblem& problem, Index c) {
  if (problem.matrix) return problem.matrix->metric[c].a_n;
  const Index j = problem.j[c];
  return problem.inverse_mass[problem.i[c]] + (j == ground ? 0 : problem.inverse_mass[j]);
}

/// The contact's diagonal block of the Delassus operator, 1/kg.
ContactMetric metric(const ContactProblem& problem, Index c) {
  if (problem.matrix) return problem.matrix->metric[c];
  if (problem.has_arms()) return bound_of(delassus_block(problem, c), problem.normal[c]);
  const double kappa = problem.kappa[c], a_n = mobility(problem, c);
  return {a_n, (1 + 1 / sphere_inertia * kappa * kappa) * a_n};
}

double inverse_or_zero(double a) {
  return a > 0 ? 1 / a : 0;
}

double power_of_two_below(double a) {
  return a > 0 ? std::exp2(std::ilogb(a)) : 1;
}

}  // namespace

PackedUnits choose_units(const ContactProblem& problem, const Comm& comm) {
  std::array<double, 2> most{};  // speed, a
  for (Index c = 0; c < problem.contacts(); ++c) {
    const double a = mobility(problem, c);
    if (a == 0) continue;
    most = {std::max(most[0], problem.free_velocity[c].cwiseAbs().maxCoeff()),
            std::max(most[1], a)};
  }
  comm.max(most);
  const double velocity = power_of_two_below(most[0]);
  return {.impulse = velocity / power_of_two_below(most[1]), .velocity = velocity};
}

template <int dimension>
ContactBlocks<dimension, double> pack(const ContactProblem& problem, const PackedUnits& units,
                                      Index owned) {
  const double unit_of_inverse_mass = units.velocity / units.impulse;
  ContactBlocks<dimension, double> packed;
  packed.owned = owned;
  packed.rows = static_cast<Index>(problem.inverse_mass.size()) + 1;
  packed.boundary = blocks_for(problem.boundary);
  for (Index b = 0; b < owned; ++b)
    packed.inverse_mass.push_back(problem.inverse_mass[b] / unit_of_inverse_mass);
  if (problem.matrix) packed.matrix = pack(*problem.matrix, unit_of_inverse_mass);
  if constexpr (dimension == levers) {
    const auto matrix = [](double c, const Mat3& m) -> RowMatrix<double> {
      return {Lanes{c, c, c, 0, m(0, 0), m(1, 1), m(2, 2), 0},
              Lanes{0, 0, 0, 0, m(0, 1), m(1, 2), m(2, 0), 0}};
    };
    for (Index b = 0; b < owned; ++b) {
      const double w = packed.inverse_mass[b];
      const Mat3 factor = problem.turning[b] / unit_of_inverse_mass;
      const Mat3 inverse = factor.isZero(0) ? Mat3(Mat3::Zero()) : Mat3(factor.inverse());
      packed.turning.push_back({matrix(w, factor), matrix(inverse_or_zero(w), inverse)});
    }
  }

  const Index zero_row = packed.rows - 1;
  ContactBlock<dimension, double> empty{};
  std::fill_n(empty.i, lane_count, zero_row);
  std::fill_n(empty.j, lane_count, zero_row);
  packed.blocks.assign(total_blocks(problem), empty);

  for_each_place(problem, [&](Index c, std::size_t at, int l) {
    ContactBlock<dimension, double>& block = packed.blocks[at];
    const ContactMetric s = metric(problem, c);
    const double a_n = s.a_n / unit_of_inverse_mass;
    const Vec3 n = problem.normal[c], b = problem.free_velocity[c] / units.velocity;
    block.i[l] = problem.i[c];
    block.j[l] = problem.j[c] == ground ? zero_row : problem.j[c];
    for (int d = 0; d < 3; ++d) block.normal[d][l] = n[d];
    block.cohesion[l] = problem.cohesion_of(c) / units.impulse;
    block.a_n[l] = static_cast<float>(a_n);
    block.inverse_a_n[l] = static_cast<float>(inverse_or_zero(a_n));
    if constexpr (dimension == 1) {
      block.free_impulse[0][l] = block.inverse_a_n[l] * n.dot(b);
    } else {
      const double a_t = s.a_t / unit_of_inverse_mass;
      block.kappa[l] = problem.matrix || problem.has_arms() ? 0 : problem.kappa[c];
      block.friction[l] = problem.friction_of(c);
      block.a_t[l] = static_cast<float>(a_t);
      block.inverse_a_t[l] = static_cast<float>(inverse_or_zero(a_t));
      const Vec3 b_n = n.dot(b) * n;
      const Vec3 scaled =
          double(block.inverse_a_n[l]) * b_n + double(block.inverse_a_t[l]) * (b - b_n);
      for (int d = 0; d < 3; ++d) block.free_impulse[d][l] = scaled[d];
      if constexpr (dimension == levers)
        for (int d = 0; d < 3; ++d) {
          block.arm_i[d][l] = problem.arm_i[c][d];
          block.arm_j[d][l] = problem.j[c] == ground ? 0 : problem.arm_j[c][d];
        }
    }
  });
  return packed;
}

template <int dimension>
ContactBlocks<dimension, float> round(const ContactBlocks<dimension, double>& contacts) {
  ContactBlocks<dimension, float> rounded;
  rounded.boundary = contacts.boundary;
  rounded.owned = contacts.owned;
  rounded.rows = contacts.rows;
  rounded.inverse_mass.assign(contacts.inverse_mass.begin(), contacts.inverse_mass.end());
  if (contacts.matrix) rounded.matrix = round(contacts.matrix);
  const auto rounded_matrix = [](const RowMatrix<double>& m) -> RowMatrix<float> {
    return {convert<float>(m.diagonal), convert<float>(m.beside)};
  };
  for (const Turning<double>& from : contacts.turning)
    rounded.turning.push_back({rounded_matrix(from.factor), rounded_matrix(from.inverse)});
  rounded.blocks.resize(contacts.blocks.size());
  for (std::size_t at = 0; at < contacts.blocks.size(); ++at) {
    const ContactBlock<dimension, double>& from = contacts.blocks[at];
    ContactBlock<dimension, float>& to = rounded.blocks[at];
    for (int d = 0; d < 3; ++d) to.normal[d] = convert<float>(from.normal[d]);
    for (int d = 0; d < components<dimension>; ++d)
      to.free_impulse[d] = convert<float>(from.free_impulse[d]);
    to.cohesion = convert<float>(from.cohesion);
    to.a_n = from.a_n;
    to.inverse_a_n = from.inverse_a_n;
    if constexpr (dimension == levers)
      for (int d = 0; d < 3; ++d) {
        to.arm_i[d] = convert<float>(from.arm_i[d]);
        to.arm_j[d] = convert<float>(from.arm_j[d]);
      }
    if constexpr (dimension != 1) {
      to.kappa = convert<float>(from.kappa);
      to.friction = convert<float>(from.friction);
      to.a_t = from.a_t;
      to.inverse_a_t = from.inverse_a_t;
    }
    std::copy_n(from.i, lane_count, to.i);
    std::copy_n(from.j, lane_count, to.j);
  }
  return rounded;
}

template <int dimension>
Impulses<dimension, double> pack_impulses(const ContactProblem& problem, const PackedUnits& units,
                                          const std::vector<Vec3>& impulse) {
  Impulses<dimension, double> packed(total_blocks(problem));
  for_each_place(problem, [&](Index c, std::size_t at, int l) {
    if (mobility(problem, c) == 0) return;
    if constexpr (dimension == 1)
      packed[at].at[0][l] = problem.normal[c].dot(impulse[c]) / units.impulse;
    else
      for (int d = 0; d < 3; ++d) packed[at].at[d][l] = impulse[c][d] / units.impulse;
  });
  return packed;
}

template <int dimension>
void unpack_impulses(const ContactProblem& problem, const PackedUnits& units,
                     const Impulses<dimension, double>& packed, std::vector<Vec3>& impulse) {
  for_each_place(problem, [&](Index c, std::size_t at, int l) {
    if constexpr (dimension == 1)
      impulse[c] = packed[at].at[0][l] * units.impulse * problem.normal[c];
    else
      for (int d = 0; d < 3; ++d) impulse[c][d] = packed[at].at[d][l] * units.impulse;
  });
}

template ContactBlocks<1, double> pack<1>(const ContactProblem&, const PackedUnits&, Index);
template ContactBlocks<3, double> pack<3>(const ContactProblem&, const PackedUnits&, Index);
template ContactBlocks<1, float> round<1>(const ContactBlocks<1, double>&);
template ContactBlocks<3, float> round<3>(const ContactBlocks<3, double>&);
template Impulses<1, double> pack_impulses<1>(const ContactProblem&, const PackedUnits&,
                                              const std::vector<Vec3>&);
template Impulses<3, double> pack_impulses<3>(const ContactProblem&, const PackedUnits&,
                                              const std::vector<Vec3>&);
template void unpack_impulses<1>(const ContactProblem&, const PackedUnits&,
                                 const Impulses<1, double>&, std::vector<Vec3>&);
template void unpack_impulses<3>(const ContactProblem&, const PackedUnits&,
                                 const Impulses<3, double>&, std::vector<Vec3>&);
template ContactBlocks<levers, double> pack<levers>(const ContactProblem&, const PackedUnits&,
                                                    Index);
template ContactBlocks<levers, float> round<levers>(const ContactBlocks<levers, double>&);
template Impulses<levers, double> pack_impulses<levers>(const ContactProblem&, const PackedUnits&,
                                                        const std::vector<Vec3>&);
template void unpack_impulses<levers>(const ContactProblem&, const PackedUnits&,
                                      const Impulses<levers, double>&, std::vector<Vec3>&);

}  // namespace spall
