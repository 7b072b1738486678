// Tensors are worked on for some bodies at once; curves, yield and failure body by body.
// SPDX-License-Identifier: BSD-3-Clause
#include "solid/bodies_step.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/kernels.hpp"
#include "solid/flaws.hpp"
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
/// Where the search for the compression of matter between voids begins at least, how far it goes,
/// and the error (of the bulk modulus) at which it ends.
constexpr double least_matter = 0.95, most_matter = 2, tension_error = 1e-7;
/// Of the pressure at which no pores are left.
constexpr double crushing_error = 1e-9;

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
void find_intact(const Bodies& bodies, const std::vector<SolidLaw>& laws,
                 const std::array<Index, pair_lanes>& row, const PairLanes& mises,
                 PairLanes* intact, PairLanes* sliding) {
  for (std::size_t l = 0; l < pair_lanes; ++l) {
    const SolidLaw& law = laws[bodies.material[row[l]]];
    if (!law.brittle() || mises[l] == 0) continue;
    const double pressure = bodies.pressure[row[l]];
    const double stress = intact_stress(law, bodies.damage[row[l]], mises[l], pressure);
    (*intact)[l] = stress / mises[l];
    (*sliding)[l] = std::min(stress, law.sliding_strength(pressure));
  }
}

/// One body between its trial and its final state. The trial stress of rock is that of what is
/// intact.
struct Body {
  const SolidLaw& law;
  Index row;
  double volume, rest_volume, h;
  double late;         ///< s, over which new stresses have worked
  double stiffness;    ///< of its shear modulus at rest
  double gained;       ///< J, by the power of old stresses
  double growth;       ///< tr L, 1/s
  double shear_power;  ///< s : L, W/m^3, of the trial stress
  double mises;        ///< Pa, of the trial stress
  double around;       ///< Pa, mean of its pressure and that of its neighbours, before
  double intact;       ///< the old stress of what is intact, of the body's
  double sliding;      ///< Pa, von Mises' stress on cracks if they did not slide, at most
};

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

/// Pressure and energy at the end of a step.
struct Pressed {
  double pressure = 0;
  double energy = 0, heat = 0;  ///< J
  double sound_speed2 = 0;      ///< (m/s)^2, of the bulk
  double damage = 0, crushed = 0;
};

/// Where `over(at)`, negative at `low` and positive at `high`, is at most `error`: Newton's steps
/// by its `slope(at)`, or a half of the bracket where they leave it or shrink too slowly.
template <class F, class G>
double root_within(double low, double high, double at, double error, F&& over, G&& slope) {
  double last = high - low;
  for (int iteration = 0; iteration < 100; ++iteration) {
    const double value = over(at);
    if (std::abs(value) <= error) break;
    (value < 0 ? low : high) = at;
    const double next = at - value / slope(at);
    const bool good = next > low && next < high && std::abs(next - at) <= last / 2;
    const double from = std::exchange(at, good ? next : (low + high) / 2);
    last = std::abs(at - from);
  }
  return at;
}

/// How far pores are crushed once what is left of them bears the pressure `pressure_of(matter)`, of
/// matter that fills the share x of its volume at rest (with pores: x alpha of that at rest).
template <class F>
double crushed_by(const SolidLaw& law, double x, double crushed, F&& pressure_of) {
  if (pressure_of(x) >= law.pores.compacted) return 1;
  return root_within(
      crushed, 1, crushed, crushing_error * law.pores.compacted,
      // Pressure falls, as pores close, and what crushes them grows.
      [&](double at) { return law.crushing_pressure(at) - pressure_of(x * law.distension(at)); },
      [&](double at) {
        const double alpha = law.distension(at);
        const double stiffness = law.bulk * law.pores.distension / (alpha * alpha);  // dP/d alpha
        return 2 * stiffness * (law.pores.distension - 1) * (1 - at) + law.pores.compacted -
               law.pores.elastic;
      });
}

/// The damage of rock whose pores have been crushed: D^(1/3) grows by that of the share of pores
/// that are closed.
double crushed_damage(const SolidLaw& law, double damage, double before, double after) {
  const auto closed = [&](double crushed) {
    return std::cbrt(1 - (law.distension(crushed) - 1) / (law.pores.distension - 1));
  };
  const double grown = std::cbrt(damage) + closed(after) - closed(before);
  return std::min(1.0, grown * grown * grown);
}

/// Of metals without pores, which are most, the rest is not asked for.
template <bool plain>
Pressed pressed(const Bodies& bodies, const Body& b, const Sheared& sheared, bool melted) {
  const SolidLaw& law = b.law;
  const double damage = bodies.damage[b.row];
  const double crushed = !plain && law.pores.any() ? bodies.crushed[b.row] : 0;
  const double alpha = plain ? 1 : law.distension(crushed);
  // Of matter at rest: its density and its volume.
  const double filled = plain ? 1 : law.filled;
  const double x = bodies.compression[b.row] * filled;
  const double rest_volume = b.rest_volume * filled;
  const double acts = b.late * b.volume;
  const double before =
      bodies.internal_energy[b.row] + b.gained + acts * sheared.scale * b.shear_power;
  ColdCurve::State cold;
  // P = P_c + Gamma rho Q/m of matter so pressed, and Q depends on the work of P. The rest of the
  // volume are pores and voids.
  const auto pressure_of = [&](double matter) {
    cold = law.cold.at(matter);
    const double share = x / matter;
    const double per_heat = share * law.gruneisen / rest_volume * std::min(1.0, matter);
    const double given = before - rest_volume * cold.energy - sheared.energy;
    return (share * cold.pressure + per_heat * given) / (1 + per_heat * acts * b.growth);
  };
  Pressed after{.pressure = pressure_of(alpha * x), .damage = damage, .crushed = crushed};
  if (!plain && alpha > 1 && law.yields && after.pressure > law.crushing_pressure(crushed)) {
    after.crushed = crushed_by(law, x, crushed, pressure_of);
    after.pressure = pressure_of(x * law.distension(after.crushed));
    // Crushing breaks rock: Jutzi, Benz & Michel, Icarus 198 (2008) 242.
    if (law.brittle()) after.damage = crushed_damage(law, damage, crushed, after.crushed);
  }
  const double whole_pressure = after.pressure, whole_energy = cold.energy;
  const bool parted = damage >= 1 || melted || (!plain && law.brittle() && damage > 0);
  // A body alone may be pulled more than its neighbours: the noise of pressure opens no voids.
  const double alone = std::max(0.0, b.around - bodies.pressure[b.row]);
  const double bearable = parted ? 0 : (1 - damage) * law.strength + alone;
  if (after.pressure < -bearable) {
    // Matter between voids is less stretched: cold it is hardly so, hot it bears pressure before.
    const double low = alpha * x;
    double high = 1.1 * std::max(low, 1.0);
    while (high < most_matter && pressure_of(high) < -bearable) high *= 1.1;
    const double matter = root_within(
        low, high, std::max(low, least_matter), tension_error * law.bulk,
        [&](double at) { return pressure_of(at) + bearable; },
        [&](double at) { return x * law.density * cold.slope2 / (at * filled); });
    double pressure = pressure_of(matter);
    if (melted) after.damage = 1;
    if (!plain && law.brittle()) {
      // Cracks have opened in the share D; the rest is stretched as if there were none.
      pressure = after.damage * pressure + (1 - after.damage) * whole_pressure;
      cold.energy = after.damage * cold.energy + (1 - after.damage) * whole_energy;
    } else if (law.yields) {
      after.damage = std::min(
          1.0, std::max(after.damage, (1 - alpha * x / matter) / law.most_voids(b.rest_volume)));
    }
    after.pressure = pressure;
  }
  after.energy = before - acts * after.pressure * b.growth;
  after.heat = after.energy - rest_volume * cold.energy - sheared.energy;
  after.sound_speed2 = cold.slope2;
  return after;
}

/// Returns by how much the trial deviator is to be scaled.
double settle(Bodies& bodies, const Body& b, double* sound_speed) {
  const SolidLaw& law = b.law;
  const Index row = b.row;
  const double hot = law.homologous(bodies.heat[row] / (b.rest_volume * law.density));
  const bool melted = law.yields && hot >= 1;
  Sheared sheared;
  Pressed after;
  if (law.brittle()) {
    if (b.h > 0) bodies.damage[row] = grown_damage(law, bodies, row, b.rest_volume, b.intact, b.h);
    // What rock bears depends on its pressure, which follows from the energy, and on what crushing
    // breaks: in two rounds.
    after.pressure = bodies.pressure[row];
    after.damage = bodies.damage[row];
    for (int round = 0; round < 2; ++round) {
      sheared = sheared_rock(bodies, b, after.damage, after.pressure, hot);
      after = pressed<false>(bodies, b, sheared, melted);
    }
  } else {
    sheared = sheared_metal(bodies, b, hot);
    after = law.pores.any() ? pressed<false>(bodies, b, sheared, melted)
                            : pressed<true>(bodies, b, sheared, melted);
  }
  bodies.plastic_strain[row] += sheared.strained;
  bodies.damage[row] = after.damage;
  if (law.pores.any()) bodies.crushed[row] = after.crushed;
  bodies.internal_energy[row] = after.energy;
  bodies.heat[row] = after.heat;
  bodies.pressure[row] = after.pressure;
  const double shear = sheared.scale > 0 ? law.shear * b.stiffness : 0;
  *sound_speed = std::sqrt(after.sound_speed2 + 4 * shear / 3 / law.density);
  return sheared.scale;
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
  double heat = 0;
  for (Index first = 0; first < bodies.owned; first += pair_lanes) {
    // The last group is filled up by its last body, which comes to the same each time.
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
    PairLanes stiffness, shear, pressure, volume, x, old_volume, weight, intact = spread_pairs(1),
                                                                         sliding{};
    bool brittle = false;
    for (std::size_t l = 0; l < pair_lanes; ++l) {
      const Index b = row[l];
      const SolidLaw& law = laws[bodies.material[b]];
      pressure[l] = bodies.pressure[b];
      x[l] = bodies.compression[b];
      stiffness[l] = 1;
      if (law.steinberg.known())
        stiffness[l] =
            law.stiffness(x[l], pressure[l], bodies.heat[b] / (rest_volume[b] * law.density));
      shear[l] = law.shear * stiffness[l];
      brittle |= law.brittle();
      old_volume[l] = rest_volume[b] / x[l];
      weight[l] = rows[b].place[3];
    }
    const PairLanes compression = x * shrunk;
    volume = old_volume / shrunk;

    const LaneTensor D = symmetric_part(G);
    const LaneTensor half_step = (h * shear) * (D + LaneTensor::diagonal(D.trace() * (-1.0 / 3)));
    LaneTensor turning = s_old;
    if (brittle) {
      find_intact(bodies, laws, row, root_of(1.5 * contracted(s_old, s_old)), &intact, &sliding);
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

    PairLanes scale, new_pressure, linear, square;
    for (std::size_t l = 0; l < pair_lanes; ++l) {
      if (static_cast<Index>(l) >= count) {
        scale[l] = new_pressure[l] = linear[l] = square[l] = 0;
        continue;
      }
      const Index b = row[l];
      const SolidLaw& law = laws[bodies.material[b]];
      bodies.compression[b] = compression[l];
      heat -= bodies.heat[b];
      double c = 0;
      scale[l] = settle(bodies,
                        {.law = law,
                         .row = b,
                         .volume = volume[l],
                         .rest_volume = rest_volume[b],
                         .h = h,
                         .late = late,
                         .stiffness = stiffness[l],
                         .gained = gained[l],
                         .growth = growth[l],
                         .shear_power = shear_power[l],
                         .mises = mises[l],
                         .around = around[l],
                         .intact = intact[l],
                         .sliding = sliding[l]},
                        &c);
      heat += bodies.heat[b];
      new_pressure[l] = bodies.pressure[b];
      const double density = law.density * compression[l];
      // Never more than in a whole lattice: few neighbours would else be damped beyond the step.
      const double spacing = 2 * bodies.radius[b];
      const double whole = shape_of_lattice() * spacing * spacing * rest_volume[b];
      const double density_over_shape = 3 * density / std::max(whole, trace[l]);
      linear[l] = density_over_shape * c;
      square[l] = density_over_shape * law.slope;
    }
    const LaneTensor s = scale * trial;
    LaneTensor sigma = s + LaneTensor::diagonal(-new_pressure);
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
