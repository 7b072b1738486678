// Some bodies are worked on at once; what few need, such as cracks, body by body.
// SPDX-License-Identifier: BSD-3-Clause
#include "solid/bodies_step.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "base/kernels.hpp"
#include "solid/flaws.hpp"
#include "solid/flow_stress.hpp"
#include "solid/lane_eigen.hpp"
#include "solid/pressed.hpp"
#include "solid/rock.hpp"
#include "solid/tensors.hpp"

namespace spall {
namespace {

/// Of the largest eigenvalue, or of that of one neighbour a spacing away if it is less: shares
/// below the first are not resolved, above the second fully. What is alone and much nearer than a
/// spacing would else push with a force of 1/r, for which no step were short enough.
constexpr double unresolved = 0.1, resolved = 0.4;
/// Of what its eigenvalues would give if they were equal: a determinant above it means that all
/// directions are. With one at four tenths of the largest it is 0.816 at most, at 4 : 7 : 10.
constexpr double surely_resolved = 0.82;
/// A body is not deformed by more within a step: what moves so is not resolved in time.
constexpr double most_squeezed = 0.5, most_stretched = 2;
/// Johnson & Cook's strain at failure is that of bars with notches, in which mean tension is no
/// more than about von Mises' stress (Bridgman). Beyond, voids alone are judged.
constexpr double most_triaxial = 1;
/// Metal that is pressed by more than a bar in compression does not tear by strain, however far it
/// flows (Bao & Wierzbicki, Engineering Fracture Mechanics 72 (2005) 1049).
constexpr double least_triaxial = -1.0 / 3;
/// tr K of a body in an fcc lattice, of d^2 V.
double shape_of_lattice() {
  const auto shell = [](int bodies, double distance) {
    const double weight = std::max(0.0, neighbour_weight(distance / neighbour_reach));
    return bodies * weight * distance * distance;
  };
  static const double sum = shell(12, 1) + shell(6, std::sqrt(2.0)) + shell(24, std::sqrt(3.0));
  return sum;
}
/// The eigenvalue of a body with one neighbour a spacing away, of d^2 V.
constexpr double shape_of_pair = neighbour_weight(1 / neighbour_reach);

/// The shape tensors' inverses, and the projectors on the directions that are resolved.
struct Shapes {
  LaneTensor inverse, projector;
  bool projected = false;
};

/// `least`: of what eigenvalues are shares, if they are all less.
Shapes shapes_of(const LaneTensor& K, const PairLanes& least) {
  const LaneTensor adjoint = adjugate(K);
  const PairLanes det = determinant(K, adjoint), mean = K.trace() / 3.0;
  const PairMask sure = (det > surely_resolved * mean * mean * mean) & (mean > least);
  const PairLanes none{}, one = spread_pairs(1);
  Shapes shapes{.inverse = select(sure, 1.0 / det, none) * adjoint,
                .projector = LaneTensor::diagonal(one),
                .projected = any_lane(~sure)};
  if (!shapes.projected) return shapes;
  const LaneEigen of = eigen_of(K);
  const PairLanes whole = larger(least, larger(of.value[0], larger(of.value[1], of.value[2])));
  PairLanes share[3], inverse[3];
  for (int e = 0; e < 3; ++e) {
    const PairMask seen = of.value[e] > unresolved * whole;
    const PairLanes t = smaller(one, (of.value[e] / whole - unresolved) / (resolved - unresolved));
    share[e] = select(seen, t * t * (3.0 - 2.0 * t), none);
    inverse[e] = select(seen, 1.0 / of.value[e], none);
  }
  shapes.inverse = select(sure, shapes.inverse, of.with(inverse));
  shapes.projector = select(sure, shapes.projector, of.with(share));
  return shapes;
}

/// Some bodies' stress, mean and deviator, as fields hold them.
LaneTensor deviator_of(const Bodies& bodies, const LaneRows& rows) {
  LaneTensor s;
  for (std::size_t l = 0; l < pair_lanes; ++l) {
    const Vec3 &direct = bodies.direct_stress[rows[l]], &shear = bodies.shear_stress[rows[l]];
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
void find_intact(const Bodies& bodies, const LaneLaws& laws, const LaneRows& rows,
                 const PairLanes& mises, PairLanes* intact, PairLanes* sliding) {
  for (std::size_t l = 0; l < pair_lanes; ++l) {
    const SolidLaw& law = laws[l];
    if (!law.brittle() || mises[l] == 0) continue;
    const double pressure = bodies.pressure[rows[l]];
    const double stress = intact_stress(law, bodies.damage[rows[l]], mises[l], pressure);
    (*intact)[l] = stress / mises[l];
    (*sliding)[l] = std::min(stress, law.sliding_strength(pressure));
  }
}

/// The share of their flow stress that bodies bear. Rock is judged by its cracks.
PairLanes bearing_shares(const Group& g, const PairLanes& damage) {
  const PairLanes brittle = g.laws.of(&SolidLaw::brittle), one = spread_pairs(1);
  return select((damage < 1.0) & (brittle == 0.0), one - damage, one);
}

/// The plastic strains that bring bodies back to their flow stress, if they have one; 0 where their
/// trial stress is less. `hot`: homologous temperatures. `bears`: `bearing_shares`.
PairLanes flowing_strains(const Bodies& bodies, const Group& g, const PairLanes& hot,
                          const PairLanes& bears) {
  const PairLanes damage = g.rows.load(bodies.damage);
  // All over the share, so that the flow stress is that of whole metal.
  const PairLanes none{}, trial = select(g.stiffness > 0.0, g.mises / (g.stiffness * bears), none);
  PairLanes least;
  for (std::size_t l = 0; l < pair_lanes; ++l) {
    const SolidLaw& law = g.laws[l];
    const bool whole = law.brittle() ? !law.rock.known() : damage[l] < 1;
    least[l] = law.yields && whole ? law.least_flow_stress(hot[l]) : infinity;
  }
  const PairMask asked = (hot < 1.0) & (trial > least);
  if (g.h == 0 || !any_lane(asked)) return none;
  return plastic_increments(asked, flow_stress_of(g.laws, hot), g.laws.of(&SolidLaw::shear) / bears,
                            trial, g.rows.load(bodies.plastic_strain), g.h);
}

/// What is left of some bodies' trial deviator.
struct Sheared {
  PairLanes scale{};
  PairLanes energy{};    ///< J, elastic
  PairLanes strained{};  ///< plastic strain
};

/// Johnson and Cook's sum of metal that flows by `flowing`: from 1 on it fails.
double strained_by(const SolidLaw& law, double strained, double flowing, double triaxiality,
                   double h, double hot) {
  if (triaxiality > most_triaxial) return strained;
  const double most = law.failure_strain(triaxiality, flowing / h, hot);
  return most > 0 ? strained + flowing / most : std::max(strained, 1.0);
}

/// Pa, that metal bears once it has failed: friction, and no more than what is whole.
double rubbing_stress(const SolidLaw& law, double stiffness, double pressure, double hot) {
  const double rubs = law.brittle() ? 0 : law.sliding_strength(pressure);
  return rubs > 0 ? std::min(rubs, stiffness * flow_stress_of(law, hot).at(0, 0).stress) : 0;
}

/// Metals return to their flow stress, by the plastic strains `flowing`, and fail where they have
/// flown too far: over a strain whose work is the fracture energy, or less. What has failed slides.
/// Of rock it is found anew.
Sheared sheared_metals(Bodies& bodies, const Group& g, const PairLanes& hot, const PairMask& melted,
                       const PairLanes& bears, const PairLanes& flowing) {
  const PairLanes none{}, one = spread_pairs(1);
  const PairLanes shear = g.stiffness * g.laws.of(&SolidLaw::shear);
  PairLanes damage = g.rows.load(bodies.damage);
  const PairMask fluid = (damage >= 1.0) | melted | (shear <= 0.0), flows = flowing > 0.0;
  const PairLanes flown = larger(none, one - 3.0 * shear * flowing / g.mises);
  Sheared left{.scale = select(fluid, none, select(flows, flown, one)), .strained = flowing};
  const std::uint8_t flowing_lanes = bits_of_mask(flows), fluid_lanes = bits_of_mask(fluid);
  if (flowing_lanes && g.laws.any([](const SolidLaw& law) { return law.flow.fails(); })) {
    PairLanes strained = g.rows.load(bodies.strained);
    for (std::size_t l = 0; l < pair_lanes; ++l) {
      const SolidLaw& law = g.laws[l];
      if (!(flowing_lanes >> l & 1) || !law.flow.fails()) continue;
      const double stress = left.scale[l] * g.mises[l];
      const double triaxiality = stress > 0 ? -g.around[l] / stress : 0;
      if (triaxiality < least_triaxial) continue;
      if (strained[l] < 1)
        strained[l] = strained_by(law, strained[l], flowing[l], triaxiality, g.h, hot[l]);
      else
        damage[l] +=
            flowing[l] / law.parting_strain(std::min(triaxiality * bears[l], most_triaxial),
                                            stress / bears[l], g.rest_volume[l]);
      if (strained[l] >= 1 && law.fracture_energy == 0) damage[l] = 1;
      damage[l] = std::min(damage[l], 1.0);
      if (damage[l] == 1) left.scale[l] = 0;
    }
    g.rows.store(damage, bodies.damage);
    g.rows.store(strained, bodies.strained);
  }
  if (fluid_lanes && g.laws.any([](const SolidLaw& law) { return law.rock.failed_friction > 0; }))
    for (std::size_t l = 0; l < pair_lanes; ++l) {
      if (!(fluid_lanes >> l & 1) || g.mises[l] == 0) continue;
      const double rubs =
          rubbing_stress(g.laws[l], g.stiffness[l], bodies.pressure[g.rows[l]], hot[l]);
      if (rubs == 0) continue;
      const double stress = std::min(g.mises[l], rubs);
      left.scale[l] = stress / g.mises[l];
      left.strained[l] = (g.mises[l] - stress) / (3 * shear[l]);
    }
  const PairLanes stress = left.scale * g.mises;
  left.energy = select(stress > 0.0, g.volume * stress * stress / (6.0 * shear), none);
  return left;
}

/// Rock returns to what its intact share bears at this pressure, and its cracks slide. `flowing`:
/// plastic strain of what has a flow stress.
void shear_rock(const Group& g, std::size_t l, double damage, double pressure, double hot,
                double flowing, Sheared* left) {
  const SolidLaw& law = g.laws[l];
  left->scale[l] = left->energy[l] = left->strained[l] = 0;
  const double mises = g.mises[l], whole = 1 - damage;
  if (mises == 0 || hot >= 1) return;
  const double intact = law.rock.known() ? std::min(mises, law.intact_strength(pressure))
                                         : mises - 3 * law.shear * flowing;
  const double slides = std::min({intact, g.sliding[l], law.sliding_strength(pressure)});
  double flown = whole * (mises - intact);
  if (slides > 0) flown += damage * (std::min(mises, g.sliding[l]) - slides);
  left->scale[l] = (whole * intact + damage * slides) / mises;
  left->energy[l] =
      g.volume[l] * (whole * intact * intact + damage * slides * slides) / (6 * law.shear);
  left->strained[l] = flown / (3 * law.shear);
}

/// What became of some bodies.
struct Settled {
  PairLanes scale{};        ///< of the trial deviator, what is left
  PairLanes pressure{};     ///< Pa
  PairLanes gained{};       ///< J, heat
  PairLanes sound_speed{};  ///< m/s, of longitudinal waves
};

Settled settle(Bodies& bodies, const Group& g) {
  const PairLanes none{}, density = g.laws.of(&SolidLaw::density);
  const PairLanes heat = g.rows.load(bodies.heat);
  const PairLanes to_melt = g.rest_volume * density * g.laws.of(&SolidLaw::melting_heat);
  const PairLanes hot = larger(heat / to_melt, none);
  const PairLanes yields = g.laws.of(&SolidLaw::yields);
  const PairMask melted = (yields > 0.0) & (hot >= 1.0);
  const bool rock = g.laws.any(&SolidLaw::brittle);
  if (rock && g.h > 0)
    for (Index l = 0; l < g.rows.count(); ++l)
      if (g.laws[l].brittle())
        bodies.damage[g.rows[l]] =
            grown_damage(g.laws[l], bodies, g.rows[l], g.rest_volume[l], g.intact[l], g.h);
  const PairLanes bears = bearing_shares(g, g.rows.load(bodies.damage));
  const PairLanes flowing = flowing_strains(bodies, g, hot, bears);
  Sheared left = sheared_metals(bodies, g, hot, melted, bears, flowing);
  Pressed after{.pressure = g.rows.load(bodies.pressure), .damage = g.rows.load(bodies.damage)};
  // What rock bears depends on its pressure, which follows from the energy, and on what crushing
  // breaks: in two rounds.
  for (int round = 0; round < (rock ? 2 : 1); ++round) {
    for (std::size_t l = 0; rock && l < pair_lanes; ++l)
      if (g.laws[l].brittle())
        shear_rock(g, l, after.damage[l], after.pressure[l], hot[l], flowing[l], &left);
    after = pressed(bodies, g, left.scale, left.energy, melted);
  }
  g.rows.store(g.compression, bodies.compression);
  g.rows.store(g.rows.load(bodies.plastic_strain) + left.strained, bodies.plastic_strain);
  g.rows.store(after.damage, bodies.damage);
  if (g.laws.any(has_pores)) g.rows.store(after.crushed, bodies.crushed);
  g.rows.store(after.energy, bodies.internal_energy);
  g.rows.store(after.heat, bodies.heat);
  g.rows.store(after.pressure, bodies.pressure);
  const PairLanes shear_speed2 = 4.0 * g.laws.of(&SolidLaw::shear) * g.stiffness / (3.0 * density);
  return {.scale = left.scale,
          .pressure = after.pressure,
          .gained = after.heat - heat,
          .sound_speed =
              square_root(after.sound_speed2 + select(left.scale > 0.0, shear_speed2, none))};
}

/// What yields and no neighbour holds has failed. It would else not see those that have, and keep
/// the pressure that it was left with among them.
void break_off(const PairMask& alone, const LaneLaws& laws, const LaneRows& rows, Bodies& bodies) {
  const std::uint8_t lanes = bits_of_mask(alone);
  for (std::size_t l = 0; lanes && l < pair_lanes; ++l)
    if (lanes >> l & 1 && laws[l].yields) bodies.damage[rows[l]] = 1;
}

}  // namespace

std::vector<double> rest_volumes(const Bodies& bodies, const std::vector<SolidLaw>& laws) {
  std::vector<double> volumes(bodies.size());
  for (Index b = 0; b < bodies.size(); ++b) {
    volumes[b] = std::isfinite(bodies.mass[b]) ? bodies.mass[b] / laws[bodies.material[b]].density
                                               : volume_of_lattice(2 * bodies.radius[b]);
  }
  return volumes;
}

double elastic_energy(const Bodies& bodies) {
  double energy = 0;
  for (Index b = 0; b < bodies.owned; ++b) energy += bodies.internal_energy[b] - bodies.heat[b];
  return energy;
}

SPALL_KERNEL(double, update_bodies,
             (Bodies & bodies, const std::vector<SolidLaw>& laws,
              const std::vector<double>& rest_volume, std::span<const Index> which, double h,
              double late, const ShapeRow* shapes, const MotionRow* rows, ResponseRow* responses),
             (bodies, laws, rest_volume, which, h, late, shapes, rows, responses)) {
  const double lattice = shape_of_lattice();
  double heat = 0;
  for (; !which.empty(); which = which.subspan(std::min(which.size(), pair_lanes))) {
    const LaneRows row(which);
    const LaneLaws law(laws, bodies.material, row);
    std::array<Index, pair_lanes> places;
    for (std::size_t l = 0; l < pair_lanes; ++l) places[l] = doubles_a_row * row[l];
    PairLanes k[16];
    for (int n = 0; n < 16; n += 4)
      gather_half<shape_width>(reinterpret_cast<const double*>(shapes) + n, places.data(), &k[n],
                               &k[n + 1], &k[n + 2], &k[n + 3]);
    const LaneTensor K{{{k[0], k[5], k[4]}, {k[5], k[1], k[3]}, {k[4], k[3], k[2]}}};
    const LaneTensor M{{{k[6], k[7], k[8]}, {k[9], k[10], k[11]}, {k[12], k[13], k[14]}}};
    const PairLanes at_rest = row.load(rest_volume), spacing = 2.0 * row.load(bodies.radius);
    const PairLanes extent = spacing * spacing * at_rest;
    const Shapes shape = shapes_of(K, shape_of_pair * extent);
    const PairLanes trace = K.trace();
    break_off(trace == 0.0, law, row, bodies);
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
    const PairLanes pressure = row.load(bodies.pressure), x = row.load(bodies.compression);
    PairLanes weight, stiffness = spread_pairs(1), intact = spread_pairs(1), sliding{};
    for (std::size_t l = 0; l < pair_lanes; ++l) weight[l] = rows[row[l]].place[3];
    if (law.any([](const SolidLaw& metal) { return metal.steinberg.known(); }))
      for (std::size_t l = 0; l < pair_lanes; ++l)
        if (law[l].steinberg.known())
          stiffness[l] = law[l].stiffness(x[l], pressure[l],
                                          bodies.heat[row[l]] / (at_rest[l] * law[l].density));
    const PairLanes shear = stiffness * law.of(&SolidLaw::shear);
    const PairLanes compression = x * shrunk, old_volume = at_rest / x;
    const PairLanes volume = old_volume / shrunk;

    const LaneTensor D = symmetric_part(G);
    const LaneTensor half_step = (h * shear) * (D + LaneTensor::diagonal(D.trace() * (-1.0 / 3)));
    LaneTensor turning = s_old;
    if (law.any(&SolidLaw::brittle)) {
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

    Settled settled = settle(bodies, {.rows = row,
                                      .laws = law,
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
    const PairLanes density = law.of(&SolidLaw::density), slope = law.of(&SolidLaw::slope);
    for (auto l = static_cast<std::size_t>(row.count()); l < pair_lanes; ++l) settled.gained[l] = 0;
    heat += sum_of_lanes(settled.gained);
    // Never more than in a whole lattice: few neighbours would else be damped beyond the step.
    const PairLanes density_over_shape =
        3.0 * density * compression / larger(lattice * extent, trace);
    const PairLanes linear = density_over_shape * settled.sound_speed;
    const PairLanes square = density_over_shape * slope;
    const LaneTensor s = settled.scale * trial;
    LaneTensor sigma = s + LaneTensor::diagonal(-settled.pressure);
    if (shape.projected) sigma = shape.projector * sigma * shape.projector;
    // Forces are summed with the volumes and over the neighbours that K was: else there were a
    // torque.
    const LaneTensor T = (volume / weight) * (sigma * shape.inverse);
    const LaneTensor E = symmetric_part(L);
    const PairLanes answer[16] = {T.at[0][0], T.at[0][1], T.at[0][2], T.at[1][0],
                                  T.at[1][1], T.at[1][2], T.at[2][0], T.at[2][1],
                                  T.at[2][2], E.at[0][0], E.at[1][1], E.at[2][2],
                                  E.at[1][2], E.at[2][0], E.at[0][1], linear};
    for (int n = 0; n < 16; n += 4) {
      RowHalf half[pair_lanes];
      halves_of_pairs(answer[n], answer[n + 1], answer[n + 2], answer[n + 3], half);
      for (Index l = 0; l < row.count(); ++l) responses[row[l]].at[n / 4] = half[l];
    }
    for (Index l = 0; l < row.count(); ++l) {
      const Index b = row[l];
      responses[b].at[4][0] = square[l];
      bodies.direct_stress[b] = {s.at[0][0][l], s.at[1][1][l], s.at[2][2][l]};
      bodies.shear_stress[b] = {s.at[1][2][l], s.at[2][0][l], s.at[0][1][l]};
    }
  }
  return heat;
}

}  // namespace spall
