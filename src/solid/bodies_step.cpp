// Tensors are worked on for some bodies at once, as pressures are; yield and failure body by body.
// SPDX-License-Identifier: BSD-3-Clause
#include "solid/bodies_step.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "base/kernels.hpp"
#include "solid/flaws.hpp"
#include "solid/pressed.hpp"
#include "solid/rock.hpp"
#include "solid/tensors.hpp"

namespace spall {
namespace {

/// Of the largest eigenvalue: shares below the first are not resolved, above the second fully.
constexpr double unresolved = 0.1, resolved = 0.4;
/// Of what its eigenvalues would give if they were equal: a determinant above it means that all
/// directions are resolved.
constexpr double surely_resolved = 0.8;
/// A body is not deformed by more within a step: what moves so is not resolved in time.
constexpr double most_squeezed = 0.5, most_stretched = 2;
/// Johnson & Cook's strain at failure is that of bars with notches, in which mean tension is no
/// more than about von Mises' stress (Bridgman). Beyond, voids alone are judged.
constexpr double most_triaxial = 1;
/// tr K of a body in an fcc lattice, of d^2 V.
double shape_of_lattice() {
  const auto shell = [](int bodies, double distance) {
    const double weight = std::max(0.0, neighbour_weight(distance / neighbour_reach));
    return bodies * weight * distance * distance;
  };
  static const double sum = shell(12, 1) + shell(6, std::sqrt(2.0)) + shell(24, std::sqrt(3.0));
  return sum;
}

/// The shape tensors' inverses, and the projectors on the directions that are resolved.
struct Shapes {
  LaneTensor inverse, projector;
  bool projected = false;
};

void resolve(const LaneTensor& K, std::size_t l, Shapes& shapes) {
  Eigen::Matrix3d k;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) k(i, j) = K.at[i][j][l];
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> of(k);
  const Vec3 value = of.eigenvalues();
  Vec3 share = Vec3::Zero(), inverse = Vec3::Zero();
  for (int e = 0; e < 3; ++e) {
    if (!(value[e] > unresolved * value[2]) || value[2] <= 0) continue;
    const double t = std::min(1.0, (value[e] / value[2] - unresolved) / (resolved - unresolved));
    share[e] = t * t * (3 - 2 * t);
    inverse[e] = 1 / value[e];
  }
  const Eigen::Matrix3d& v = of.eigenvectors();
  const Eigen::Matrix3d p = v * share.asDiagonal() * v.transpose();
  const Eigen::Matrix3d n = v * inverse.asDiagonal() * v.transpose();
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      shapes.projector.at[i][j][l] = p(i, j);
      shapes.inverse.at[i][j][l] = n(i, j);
    }
}

Shapes shapes_of(const LaneTensor& K) {
  const LaneTensor adjoint = adjugate(K);
  const PairLanes det = determinant(K, adjoint), mean = K.trace() / 3.0;
  const PairMask sure = det > surely_resolved * mean * mean * mean;
  Shapes shapes{.inverse = select(sure, 1.0 / det, PairLanes{}) * adjoint,
                .projector = LaneTensor::diagonal(spread_pairs(1))};
  const std::uint8_t unsure = static_cast<std::uint8_t>(~bits_of_mask(sure));
  shapes.projected = unsure != 0;
  for (std::size_t l = 0; l < pair_lanes; ++l)
    if (unsure >> l & 1) resolve(K, l, shapes);
  return shapes;
}

/// Some bodies' stress, mean and deviator, as fields hold them.
LaneTensor deviator_of(const Bodies& bodies, const std::array<Index, pair_lanes>& row) {
  LaneTensor s;
  for (std::size_t l = 0; l < pair_lanes; ++l) {
    const Vec3 &direct = bodies.direct_stress[row[l]], &shear = bodies.shear_stress[row[l]];
    for (int k = 0; k < 3; ++k) {
      s.at[k][k][l] = direct[k];
      s.at[(k + 1) % 3][(k + 2) % 3][l] = s.at[(k + 2) % 3][(k + 1) % 3][l] = shear[k];
    }
  }
  return s;
}

/// R s R^T by Cayley's rotation of half the angle vector q.
LaneTensor turned(const LaneTensor& s, const PairLanes (&q)[3]) {
  const PairLanes q2 = q[0] * q[0] + q[1] * q[1] + q[2] * q[2], f = 2.0 / (1.0 + q2);
  LaneTensor R;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) R.at[i][j] = f * q[i] * q[j];
  const PairLanes diagonal = 1.0 - f * q2;
  for (int k = 0; k < 3; ++k) {
    R.at[k][k] += diagonal;
    R.at[(k + 2) % 3][(k + 1) % 3] += f * q[k];
    R.at[(k + 1) % 3][(k + 2) % 3] -= f * q[k];
  }
  return R * s * R.transposed();
}

/// Of bodies that bear von Mises' stress `mises`: that of what is intact, of it; and that of
/// the cracks.
void find_intact(const Bodies& bodies, const std::array<const SolidLaw*, pair_lanes>& law,
                 const std::array<Index, pair_lanes>& row, const PairLanes& mises,
                 PairLanes* intact, PairLanes* sliding) {
  for (std::size_t l = 0; l < pair_lanes; ++l) {
    if (!law[l]->brittle() || mises[l] == 0) continue;
    const double pressure = bodies.pressure[row[l]];
    const double stress = intact_stress(*law[l], bodies.damage[row[l]], mises[l], pressure);
    (*intact)[l] = stress / mises[l];
    (*sliding)[l] = std::min(stress, law[l]->sliding_strength(pressure));
  }
}

/// One body of a `Group`, and its numbers there.
struct Body {
  const SolidLaw& law;
  Index row;
  double volume, h, stiffness, mises, around, sliding;
};

Body body_of(const Group& g, std::size_t l) {
  return {.law = *g.law[l],
          .row = g.row[l],
          .volume = g.volume[l],
          .h = g.h,
          .stiffness = g.stiffness[l],
          .mises = g.mises[l],
          .around = g.around[l],
          .sliding = g.sliding[l]};
}

/// What is left of a body's trial deviator.
struct Sheared {
  double scale = 0;
  double energy = 0;    ///< J, elastic
  double strained = 0;  ///< plastic strain
};

/// Pa, that metal bears once it has failed: friction, and no more than what is whole.
double rubbing_stress(const Bodies& bodies, const Body& b, double hot) {
  const double rubs = b.law.sliding_strength(bodies.pressure[b.row]);
  return rubs > 0 ? std::min(rubs, b.stiffness * b.law.flow_stress(0, 0, hot).stress) : 0;
}

/// Metals return to their flow stress, and fail where they have flown too far. What has failed
/// slides.
Sheared sheared_metal(Bodies& bodies, const Body& b, double hot) {
  const SolidLaw& law = b.law;
  double& damage = bodies.damage[b.row];
  const bool fluid = damage >= 1 || (law.yields && hot >= 1) || b.stiffness == 0;
  Sheared left{.scale = fluid ? 0.0 : 1.0};
  if (const double rubs = fluid ? rubbing_stress(bodies, b, hot) : 0; rubs > 0 && b.mises > 0) {
    const double stress = std::min(b.mises, rubs);
    left.scale = stress / b.mises;
    left.strained = (b.mises - stress) / (3 * law.shear * b.stiffness);
  } else if (law.yields && !fluid && b.mises > 0 && b.h > 0) {
    const double trial = b.mises / b.stiffness;
    if (trial > law.least_flow_stress(hot))
      left.strained = law.plastic_increment(trial, bodies.plastic_strain[b.row], b.h, hot);
    left.scale *= std::max(0.0, 1 - 3 * law.shear * left.strained / trial);
    if (left.strained > 0 && law.flow.fails()) {
      const double stress = left.scale * b.mises;
      const double triaxiality = stress > 0 ? std::max(-most_triaxial, -b.around / stress) : 0;
      const double most = law.failure_strain(triaxiality, left.strained / b.h, hot);
      if (triaxiality <= most_triaxial)
        damage = most > 0 ? damage + left.strained / most : std::max(damage, 1.0);
      if (damage >= 1) left.scale = 0;
    }
  }
  const double stress = left.scale * b.mises;
  left.energy = stress > 0 ? b.volume * stress * stress / (6 * law.shear * b.stiffness) : 0;
  return left;
}

/// Rock returns to what its intact share bears at this pressure, and its cracks slide.
Sheared sheared_rock(const Bodies& bodies, const Body& b, double damage, double pressure,
                     double hot) {
  const SolidLaw& law = b.law;
  if (b.mises == 0 || hot >= 1) return {};
  const double whole = 1 - damage;
  double intact = b.mises;
  if (law.rock.known())
    intact = std::min(intact, law.intact_strength(pressure));
  else if (b.h > 0)
    intact -= 3 * law.shear * law.plastic_increment(intact, bodies.plastic_strain[b.row], b.h, hot);
  const double slides = std::min({intact, b.sliding, law.sliding_strength(pressure)});
  double flown = whole * (b.mises - intact);
  if (slides > 0) flown += damage * (std::min(b.mises, b.sliding) - slides);
  return {
      .scale = (whole * intact + damage * slides) / b.mises,
      .energy = b.volume * (whole * intact * intact + damage * slides * slides) / (6 * law.shear),
      .strained = flown / (3 * law.shear)};
}

/// What became of some bodies.
struct Settled {
  PairLanes scale{};        ///< of the trial deviator, what is left
  PairLanes pressure{};     ///< Pa
  PairLanes gained{};       ///< J, heat
  PairLanes sound_speed{};  ///< m/s, of longitudinal waves
};

Settled settle(Bodies& bodies, const Group& g) {
  PairLanes hot{}, yields{}, shear_speed2{}, sheared{}, strained{};
  Settled settled;
  Pressed after;
  bool rock = false;
  const auto count = static_cast<std::size_t>(g.count);
  for (std::size_t l = 0; l < count; ++l) {
    const SolidLaw& law = *g.law[l];
    const Index b = g.row[l];
    hot[l] = law.homologous(bodies.heat[b] / (g.rest_volume[l] * law.density));
    yields[l] = law.yields;
    if (law.brittle()) {
      rock = true;
      if (g.h > 0)
        bodies.damage[b] = grown_damage(law, bodies, b, g.rest_volume[l], g.intact[l], g.h);
    }
    after.pressure[l] = bodies.pressure[b];
    after.damage[l] = bodies.damage[b];
  }
  const PairMask melted = (yields > 0.0) & (hot >= 1.0);
  // What rock bears depends on its pressure, which follows from the energy, and on what crushing
  // breaks: in two rounds.
  for (int round = 0; round < (rock ? 2 : 1); ++round) {
    for (std::size_t l = 0; l < count; ++l) {
      const bool brittle = g.law[l]->brittle();
      if (round > 0 && !brittle) continue;
      const Sheared left =
          brittle ? sheared_rock(bodies, body_of(g, l), after.damage[l], after.pressure[l], hot[l])
                  : sheared_metal(bodies, body_of(g, l), hot[l]);
      settled.scale[l] = left.scale;
      sheared[l] = left.energy;
      strained[l] = left.strained;
    }
    after = pressed(bodies, g, settled.scale, sheared, melted);
  }
  for (std::size_t l = 0; l < count; ++l) {
    const SolidLaw& law = *g.law[l];
    const Index b = g.row[l];
    bodies.compression[b] = g.compression[l];
    bodies.plastic_strain[b] += strained[l];
    bodies.damage[b] = after.damage[l];
    if (law.pores.any()) bodies.crushed[b] = after.crushed[l];
    bodies.internal_energy[b] = after.energy[l];
    settled.gained[l] = after.heat[l] - bodies.heat[b];
    bodies.heat[b] = after.heat[l];
    bodies.pressure[b] = after.pressure[l];
    if (settled.scale[l] > 0) shear_speed2[l] = 4 * law.shear * g.stiffness[l] / (3 * law.density);
  }
  settled.pressure = after.pressure;
  settled.sound_speed = square_root(after.sound_speed2 + shear_speed2);
  return settled;
}

}  // namespace

std::vector<double> rest_volumes(const Bodies& bodies, const std::vector<SolidLaw>& laws) {
  std::vector<double> volumes(bodies.size());
  for (Index b = 0; b < bodies.size(); ++b) {
    const double d = 2 * bodies.radius[b];
    volumes[b] = std::isfinite(bodies.mass[b]) ? bodies.mass[b] / laws[bodies.material[b]].density
                                               : d * d * d / std::sqrt(2.0);
  }
  return volumes;
}

SPALL_KERNEL(double, update_bodies,
             (Bodies & bodies, const std::vector<SolidLaw>& laws,
              const std::vector<double>& rest_volume, double h, double late, const ShapeRow* shapes,
              MotionRow* rows, ResponseRow* responses),
             (bodies, laws, rest_volume, h, late, shapes, rows, responses)) {
  const double lattice = shape_of_lattice();
  double heat = 0;
  for (Index first = 0; first < bodies.owned; first += pair_lanes) {
    // The last group is filled up by its last body; what becomes of it there is not kept.
    std::array<Index, pair_lanes> row;
    const Index count = std::min<Index>(pair_lanes, bodies.owned - first);
    for (Index l = 0; l < static_cast<Index>(pair_lanes); ++l)
      row[l] = first + std::min(l, count - 1);
    std::array<Index, pair_lanes> places;
    for (std::size_t l = 0; l < pair_lanes; ++l) places[l] = doubles_a_row * row[l];
    PairLanes k[16];
    for (int n = 0; n < 16; n += 4)
      gather_half<shape_width>(reinterpret_cast<const double*>(shapes) + n, places.data(), &k[n],
                               &k[n + 1], &k[n + 2], &k[n + 3]);
    const LaneTensor K{{{k[0], k[5], k[4]}, {k[5], k[1], k[3]}, {k[4], k[3], k[2]}}};
    const LaneTensor M{{{k[6], k[7], k[8]}, {k[9], k[10], k[11]}, {k[12], k[13], k[14]}}};
    const Shapes shape = shapes_of(K);
    const PairLanes trace = K.trace();
    LaneTensor L = M * shape.inverse;
    if (shape.projected) L = shape.projector * L * shape.projector;

    const LaneTensor one = LaneTensor::diagonal(spread_pairs(1));
    const LaneTensor back = one + spread_pairs(-h) * L, back_adjoint = adjugate(back);
    const PairLanes shrunk =
        larger(spread_pairs(1 / most_stretched),
               smaller(spread_pairs(1 / most_squeezed), determinant(back, back_adjoint)));
    const LaneTensor L_old = (1.0 / shrunk) * (back_adjoint * L);
    const LaneTensor middle = one + spread_pairs(-h / 2) * L, middle_adjoint = adjugate(middle);
    const LaneTensor G = (1.0 / determinant(middle, middle_adjoint)) * (L * middle_adjoint);

    const LaneTensor s_old = deviator_of(bodies, row);
    std::array<const SolidLaw*, pair_lanes> law;
    PairLanes stiffness, shear, pressure, x, at_rest, weight, intact = spread_pairs(1), sliding{};
    bool brittle = false;
    for (std::size_t l = 0; l < pair_lanes; ++l) {
      const Index b = row[l];
      law[l] = &laws[bodies.material[b]];
      pressure[l] = bodies.pressure[b];
      x[l] = bodies.compression[b];
      stiffness[l] = 1;
      if (law[l]->steinberg.known())
        stiffness[l] = law[l]->stiffness(x[l], pressure[l],
                                         bodies.heat[b] / (rest_volume[b] * law[l]->density));
      shear[l] = law[l]->shear * stiffness[l];
      brittle |= law[l]->brittle();
      at_rest[l] = rest_volume[b];
      weight[l] = rows[b].place[3];
    }
    const PairLanes compression = x * shrunk, old_volume = at_rest / x;
    const PairLanes volume = old_volume / shrunk;

    const LaneTensor D = symmetric_part(G);
    const LaneTensor half_step = (h * shear) * (D + LaneTensor::diagonal(D.trace() * (-1.0 / 3)));
    LaneTensor turning = s_old;
    if (brittle) {
      find_intact(bodies, law, row, root_of(1.5 * contracted(s_old, s_old)), &intact, &sliding);
      turning = intact * s_old;
      sliding += root_of(6.0 * contracted(half_step, half_step));
    }
    const PairLanes q[3] = {0.25 * h * (G.at[2][1] - G.at[1][2]),
                            0.25 * h * (G.at[0][2] - G.at[2][0]),
                            0.25 * h * (G.at[1][0] - G.at[0][1])};
    const LaneTensor trial = turned(turning + half_step, q) + half_step;

    const PairLanes gained =
        (h - late) * old_volume * (contracted(s_old, L_old) - pressure * L_old.trace());
    const PairLanes shear_power = contracted(trial, L), growth = L.trace();
    const PairLanes mises = root_of(1.5 * contracted(trial, trial));
    // The pressure of single bodies has noise, which alternates from neighbour to neighbour.
    const PairLanes around = pressure + select(trace > 0.0, 0.5 * k[15] / trace, PairLanes{});

    const Settled settled = settle(bodies, {.row = row,
                                            .law = law,
                                            .count = count,
                                            .h = h,
                                            .late = late,
                                            .compression = compression,
                                            .volume = volume,
                                            .rest_volume = at_rest,
                                            .stiffness = stiffness,
                                            .mises = mises,
                                            .around = around,
                                            .sliding = sliding,
                                            .intact = intact,
                                            .gained = gained,
                                            .growth = growth,
                                            .shear_power = shear_power});
    PairLanes density, slope, spacing;
    for (std::size_t l = 0; l < pair_lanes; ++l) {
      density[l] = law[l]->density;
      slope[l] = law[l]->slope;
      spacing[l] = 2 * bodies.radius[row[l]];
    }
    heat += sum_of_lanes(settled.gained);
    // Never more than in a whole lattice: few neighbours would else be damped beyond the step.
    const PairLanes whole = lattice * spacing * spacing * at_rest;
    const PairLanes density_over_shape = 3.0 * density * compression / larger(whole, trace);
    const PairLanes linear = density_over_shape * settled.sound_speed;
    const PairLanes square = density_over_shape * slope;
    const LaneTensor s = settled.scale * trial;
    LaneTensor sigma = s + LaneTensor::diagonal(-settled.pressure);
    if (shape.projected) sigma = shape.projector * sigma * shape.projector;
    // Forces are summed with the volumes and over the neighbours that K was: else there were a
    // torque.
    const LaneTensor T = (volume / weight) * (sigma * shape.inverse);
    const LaneTensor E = symmetric_part(L);
    PairLanes middle_velocity[3], failed;
    for (std::size_t l = 0; l < pair_lanes; ++l) {
      const Index b = row[l];
      for (int n = 0; n < 3; ++n)
        middle_velocity[n][l] = bodies.velocity[b][n] + 0.5 * bodies.kick[b][n];
      failed[l] = rows[b].motion[3] >= infinity;
    }
    const PairLanes none{};
    const PairLanes answer[24] = {T.at[0][0],
                                  T.at[0][1],
                                  T.at[0][2],
                                  T.at[1][0],
                                  T.at[1][1],
                                  T.at[1][2],
                                  T.at[2][0],
                                  T.at[2][1],
                                  T.at[2][2],
                                  E.at[0][0],
                                  E.at[1][1],
                                  E.at[2][2],
                                  E.at[1][2],
                                  E.at[2][0],
                                  E.at[0][1],
                                  linear,
                                  square,
                                  middle_velocity[0],
                                  middle_velocity[1],
                                  middle_velocity[2],
                                  weight,
                                  failed,
                                  none,
                                  none};
    for (int n = 0; n < 24; n += 4) {
      RowHalf half[pair_lanes];
      halves_of_pairs(answer[n], answer[n + 1], answer[n + 2], answer[n + 3], half);
      for (Index l = 0; l < count; ++l) responses[row[l]].at[n / 4] = half[l];
    }
    for (Index l = 0; l < count; ++l) {
      const Index b = row[l];
      bodies.direct_stress[b] = {s.at[0][0][l], s.at[1][1][l], s.at[2][2][l]};
      bodies.shear_stress[b] = {s.at[1][2][l], s.at[2][0][l], s.at[0][1][l]};
      rows[b].place[3] = std::min(volume[l], rest_volume[b]);
      rows[b].motion[3] = bodies.damage[b] >= 1 ? infinity : bodies.pressure[b];
    }
  }
  return heat;
}

}  // namespace spall
