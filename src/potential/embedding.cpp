// Between the nodes of the table what presses is linear, and the energy its integral.
// SPDX-License-Identifier: BSD-3-Clause
#include "potential/embedding.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace spall {
namespace {

constexpr int nodes_to_rest = 256;
constexpr double most_expanded = 1.15, most_compressed = 0.6;  // d
/// Of 1/s, where the shock's pressure has no end.
constexpr double strongest = 0.8;

/// Of an fcc crystal of this spacing, with d = 1, and its slope.
struct Crowding {
  double value = 0, slope = 0;
};
Crowding crowding_of_lattice(double spacing, double reach) {
  struct Shell {
    double distance, bodies;
  };
  static const std::array<Shell, 4> shells{
      {{1, 12}, {std::sqrt(2.0), 6}, {std::sqrt(3.0), 24}, {2, 12}}};
  Crowding n;
  for (const Shell& shell : shells) {
    const double left = std::max(0.0, 1 - spacing * shell.distance / reach);
    n.value += shell.bodies * left * left;
    n.slope -= shell.bodies * 2 * left * shell.distance / reach;
  }
  return n;
}

}  // namespace

EmbeddingLaw::EmbeddingLaw(const PairPotential& p)
    : reach_(crowding_reach * p.distance),
      density_(p.embedding.density),
      cell_(p.distance * p.distance * p.distance / std::sqrt(2.0)) {
  const double reach = crowding_reach;
  at_rest_ = crowding_of_lattice(1, reach).value;
  step_ = at_rest_ / nodes_to_rest;
  const Embedding& e = p.embedding;
  const double K = e.bulk_modulus;
  const double end =
      std::max(most_compressed, std::cbrt(std::max(0.0, 1 - strongest / e.hugoniot_slope)));
  const double first = crowding_of_lattice(most_expanded, reach).value;
  const double last = crowding_of_lattice(end, reach).value;
  const auto pair_pressure = [&](double spacing) {
    const double s3 = spacing * spacing * spacing;
    return 12 * spacing * p.distance * pair_force(p, spacing * p.distance) / (6 * s3 * cell_);
  };
  nodes_.resize(static_cast<std::size_t>(last / step_) + 1);
  double spacing = most_expanded, eta = 0, pressure = 0, energy = 0;  // of the isentrope
  for (std::size_t k = 0; k < nodes_.size(); ++k) {
    const double wanted = step_ * static_cast<double>(k);
    if (wanted < first) continue;
    Crowding n = crowding_of_lattice(spacing, reach);
    for (int iteration = 0; iteration < 6; ++iteration) {
      spacing -= (n.value - wanted) / n.slope;
      n = crowding_of_lattice(spacing, reach);
    }
    const double x = 1 / (spacing * spacing * spacing), slope = -3 * x / spacing / n.slope;
    double cold = K * (x - 1);
    if (k == nodes_to_rest) cold = 0;
    if (k > nodes_to_rest) {
      const double now = 1 - 1 / x, way = now - eta, left = 1 - e.hugoniot_slope * now;
      const double shock = K * now / (left * left) * (1 - e.gruneisen * now / 2);
      // The trapezoidal rule, solved for the energy at its end.
      energy = (energy + way / 2 * (pressure + shock)) / (1 - way / 2 * e.gruneisen);
      eta = now;
      pressure = shock + e.gruneisen * energy;
      cold = std::max(0.0, pressure - pair_pressure(spacing));
    }
    nodes_[k] = {.cold = cold * slope / (x * x), .hot = e.gruneisen * slope / (x * x)};
    if (k > nodes_to_rest)
      nodes_[k].energy = nodes_[k - 1].energy + step_ * (nodes_[k - 1].cold + nodes_[k].cold) / 2;
  }
}

EmbeddingLaw::Place EmbeddingLaw::place(double crowding) const {
  const double at = crowding / step_;
  const std::size_t node = std::min(static_cast<std::size_t>(at), nodes_.size() - 2);
  return {node, at - static_cast<double>(node)};
}

EmbeddingLaw::Push EmbeddingLaw::push(double crowding, double heat) const {
  const auto [k, beyond] = place(crowding);
  const Node &low = nodes_[k], &high = nodes_[k + 1];
  const double part = std::min(beyond, 1.0);  // after its end the table stays as it is there
  const double cold = low.cold + part * (high.cold - low.cold);
  const double hot = (low.hot + part * (high.hot - low.hot)) * heat;
  if (crowding >= at_rest_) return {cold + hot, hot};
  const double left = std::max(0.0, cold + hot);
  return {left, left};
}

double EmbeddingLaw::energy(double crowding) const {
  if (crowding <= at_rest_) return 0;
  const auto [k, beyond] = place(crowding);
  const Node &low = nodes_[k], &high = nodes_[k + 1];
  const double part = std::min(beyond, 1.0);
  return low.energy + step_ * (part * (low.cold + part / 2 * (high.cold - low.cold)) +
                               (beyond - part) * high.cold);
}

}  // namespace spall
