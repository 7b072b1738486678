// Tensors are worked on for eight bodies at once; curves, yield and failure body by body.
// SPDX-License-Identifier: BSD-3-Clause
#include "solid/bodies_step.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "base/kernels.hpp"
#include "solid/flaws.hpp"
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
/// The share of voids at which metal bears nothing (Tvergaard & Needleman, Acta Metallurgica 32
/// (1984) 157).
constexpr double most_voids = 0.25;
/// Johnson & Cook's strain at failure is that of bars with notches, in which mean tension is no
/// more than about von Mises' stress (Bridgman). Beyond, voids alone are judged.
constexpr double most_triaxial = 1;
/// Where the search for the compression of matter between voids begins at least, and the error (of
/// the bulk modulus) at which it ends.
constexpr double least_matter = 0.95, tension_error = 1e-7;

/// tr K of a body in an fcc lattice, of d^2 V.
double shape_of_lattice() {
  const auto shell = [](int bodies, double distance) {
    const double left = std::max(0.0, 1 - distance / neighbour_reach);
    return bodies * left * left * distance * distance;
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
  const Lanes det = determinant(K, adjoint), mean = K.trace() / 3.0;
  const LaneMask sure = det > surely_resolved * mean * mean * mean;
  Shapes shapes{.inverse = select(sure, 1.0 / det, Lanes{}) * adjoint,
                .projector = LaneTensor::diagonal(spread(1))};
  const std::uint8_t unsure = static_cast<std::uint8_t>(~bits_of_mask(sure));
  shapes.projected = unsure != 0;
  for (std::size_t l = 0; l < lane_count; ++l)
    if (unsure >> l & 1) resolve(K, l, shapes);
  return shapes;
}

/// Eight bodies' stress, mean and deviator, as fields hold them.
LaneTensor deviator_of(const Bodies& bodies, const std::array<Index, lane_count>& row) {
  LaneTensor s;
  for (std::size_t l = 0; l < lane_count; ++l) {
    const Vec3 &direct = bodies.direct_stress[row[l]], &shear = bodies.shear_stress[row[l]];
    for (int k = 0; k < 3; ++k) {
      s.at[k][k][l] = direct[k];
      s.at[(k + 1) % 3][(k + 2) % 3][l] = s.at[(k + 2) % 3][(k + 1) % 3][l] = shear[k];
    }
  }
  return s;
}

/// R s R^T by Cayley's rotation of half the angle vector q.
LaneTensor turned(const LaneTensor& s, const Lanes (&q)[3]) {
  const Lanes q2 = q[0] * q[0] + q[1] * q[1] + q[2] * q[2], f = 2.0 / (1.0 + q2);
  LaneTensor R;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) R.at[i][j] = f * q[i] * q[j];
  const Lanes diagonal = 1.0 - f * q2;
  for (int k = 0; k < 3; ++k) {
    R.at[k][k] += diagonal;
    R.at[(k + 2) % 3][(k + 1) % 3] += f * q[k];
    R.at[(k + 1) % 3][(k + 2) % 3] -= f * q[k];
  }
  return R * s * R.transposed();
}

/// One body between its trial and its final state.
struct Body {
  const SolidLaw& law;
  Index row;
  double volume, rest_volume, h;
  double gained;       ///< J, by the power of old stresses, over half of h
  double growth;       ///< tr L, 1/s
  double shear_power;  ///< s : L, W/m^3, of the trial stress
  double mises;        ///< Pa, of the trial stress
  double around;       ///< Pa, mean of its pressure and that of its neighbours, before
};

/// Returns by how much the trial deviator is to be scaled.
double settle(Bodies& bodies, const Body& b, double* sound_speed) {
  const SolidLaw& law = b.law;
  const Index row = b.row;
  double& damage = bodies.damage[row];
  const double mass = b.rest_volume * law.density;
  const double old_heat = bodies.heat[row];
  const double hot = law.homologous(old_heat / mass);
  const bool melted = law.yields && hot >= 1;

  const double borne_before = law.borne(damage);
  if (law.flaws.known() && b.h > 0) damage = grown_damage(law, bodies, row, b.rest_volume, b.h);
  const double borne = law.borne(damage);

  double scale = damage >= 1 || melted ? 0 : borne / borne_before;
  if (law.yields && scale > 0 && b.mises > 0 && b.h > 0) {
    const double trial = b.mises / borne_before;  // between the cracks
    double strained = 0;
    const bool may = trial > law.flow.a * (law.flow.m >= 1 ? 1 - hot : 0);
    if (may) strained = law.plastic_increment(trial, bodies.plastic_strain[row], b.h, hot);
    scale *= std::max(0.0, 1 - 3 * law.shear * strained / trial);
    bodies.plastic_strain[row] += strained;
    if (strained > 0 && law.flow.fails()) {
      const double left = scale * b.mises;
      const double triaxiality = left > 0 ? std::max(-most_triaxial, -b.around / left) : 0;
      const double most = law.failure_strain(triaxiality, strained / b.h, hot);
      if (triaxiality <= most_triaxial && most > 0) damage += strained / most;
      if (damage >= 1) scale = 0;
    }
  }

  const double x = bodies.compression[row];
  const double half = b.h / 2 * b.volume;
  const double before = bodies.internal_energy[row] + b.gained + half * scale * b.shear_power;
  const double left = scale * b.mises;
  const double deviatoric = left > 0 ? b.volume * left * left / (6 * law.shear * borne) : 0;
  ColdCurve::State cold;
  // P = P_c + Gamma rho Q/m of matter so pressed, and Q depends on the work of P. The rest of the
  // volume are voids.
  const auto pressure_of = [&](double matter) {
    cold = law.cold.at(matter);
    const double share = x / matter;
    const double per_heat = share * law.gruneisen / b.rest_volume * std::min(1.0, matter);
    const double given = before - b.rest_volume * cold.energy - deviatoric;
    return (share * cold.pressure + per_heat * given) / (1 + per_heat * half * b.growth);
  };
  double pressure = pressure_of(x);
  const double whole_pressure = pressure, whole_energy = cold.energy;
  const bool parted = damage >= 1 || melted || borne < 1;
  const double bearable = parted ? 0 : (1 - damage) * law.strength;
  if (pressure < -bearable) {
    double matter = std::max(x, least_matter);
    pressure = pressure_of(matter);
    for (int k = 0; k < 20 && std::abs(pressure + bearable) > tension_error * law.bulk; ++k) {
      matter -= (pressure + bearable) * matter / (x * law.density * cold.slope2);
      pressure = pressure_of(matter);
    }
    if (melted) damage = 1;
    if (law.flaws.known()) {
      // Cracks have opened in the share D; the rest is stretched as if there were none.
      const double rest = law.borne(damage);
      pressure = damage * pressure + rest * whole_pressure;
      cold.energy = damage * cold.energy + rest * whole_energy;
    } else if (law.yields)
      damage = std::min(1.0, std::max(damage, (1 - x / matter) / most_voids));
  }

  const double energy = before - half * pressure * b.growth;
  bodies.internal_energy[row] = energy;
  bodies.heat[row] = energy - b.rest_volume * cold.energy - deviatoric;
  bodies.pressure[row] = pressure;
  *sound_speed = std::sqrt(cold.slope2 + (scale > 0 ? 4 * law.shear / 3 / law.density : 0));
  return scale;
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
              const std::vector<double>& rest_volume, double h, const ShapeRow* shapes,
              MotionRow* rows, ResponseRow* responses),
             (bodies, laws, rest_volume, h, shapes, rows, responses)) {
  double heat = 0;
  for (Index first = 0; first < bodies.owned; first += lane_count) {
    // The last group is filled up by its last body, which comes to the same each time.
    std::array<Index, lane_count> row;
    const Index count = std::min<Index>(lane_count, bodies.owned - first);
    for (Index l = 0; l < static_cast<Index>(lane_count); ++l)
      row[l] = first + std::min(l, count - 1);
    Lanes sums[2][lane_count];
    for (int half = 0; half < 2; ++half) {
      for (std::size_t l = 0; l < lane_count; ++l)
        sums[half][l] = load(reinterpret_cast<const double*>(&shapes[row[l]]) + 8 * half);
      transpose(sums[half]);
    }
    const Lanes* k = sums[0];
    const LaneTensor K{{{k[0], k[5], k[4]}, {k[5], k[1], k[3]}, {k[4], k[3], k[2]}}};
    const LaneTensor M{{{sums[0][6], sums[0][7], sums[1][0]},
                        {sums[1][1], sums[1][2], sums[1][3]},
                        {sums[1][4], sums[1][5], sums[1][6]}}};
    const Shapes shape = shapes_of(K);
    const Lanes trace = K.trace();
    LaneTensor L = M * shape.inverse;
    if (shape.projected) L = shape.projector * L * shape.projector;

    const LaneTensor one = LaneTensor::diagonal(spread(1));
    const LaneTensor back = one + spread(-h) * L, back_adjoint = adjugate(back);
    const Lanes shrunk =
        larger(spread(1 / most_stretched),
               smaller(spread(1 / most_squeezed), determinant(back, back_adjoint)));
    const LaneTensor L_old = (1.0 / shrunk) * (back_adjoint * L);
    const LaneTensor middle = one + spread(-h / 2) * L, middle_adjoint = adjugate(middle);
    const LaneTensor G = (1.0 / determinant(middle, middle_adjoint)) * (L * middle_adjoint);

    Lanes shear, pressure, volume, x, old_volume, weight;
    for (std::size_t l = 0; l < lane_count; ++l) {
      const Index b = row[l];
      const SolidLaw& law = laws[bodies.material[b]];
      shear[l] = law.borne(bodies.damage[b]) * law.shear;
      pressure[l] = bodies.pressure[b];
      x[l] = bodies.compression[b];
      old_volume[l] = rest_volume[b] / x[l];
      weight[l] = rows[b].place[3];
    }
    const Lanes compression = x * shrunk;
    volume = old_volume / shrunk;

    const LaneTensor s_old = deviator_of(bodies, row);
    const LaneTensor D = symmetric_part(G);
    const LaneTensor half_step = (h * shear) * (D + LaneTensor::diagonal(D.trace() * (-1.0 / 3)));
    const Lanes q[3] = {0.25 * h * (G.at[2][1] - G.at[1][2]), 0.25 * h * (G.at[0][2] - G.at[2][0]),
                        0.25 * h * (G.at[1][0] - G.at[0][1])};
    const LaneTensor trial = turned(s_old + half_step, q) + half_step;

    const Lanes gained =
        0.5 * h * old_volume * (contracted(s_old, L_old) - pressure * L_old.trace());
    const Lanes shear_power = contracted(trial, L), growth = L.trace();
    const Lanes mises = root_of(1.5 * contracted(trial, trial));
    // The pressure of single bodies has noise, which alternates from neighbour to neighbour.
    const Lanes around = pressure + select(trace > 0.0, 0.5 * sums[1][7] / trace, Lanes{});

    Lanes scale, new_pressure, linear, square;
    for (std::size_t l = 0; l < lane_count; ++l) {
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
                         .gained = gained[l],
                         .growth = growth[l],
                         .shear_power = shear_power[l],
                         .mises = mises[l],
                         .around = around[l]},
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
    const Lanes answer[24] = {T.at[0][0], T.at[0][1], T.at[0][2], T.at[1][0], T.at[1][1],
                              T.at[1][2], T.at[2][0], T.at[2][1], T.at[2][2], E.at[0][0],
                              E.at[1][1], E.at[2][2], E.at[1][2], E.at[2][0], E.at[0][1],
                              linear,     square};
    for (Index l = 0; l < count; ++l) {
      const Index b = row[l];
      bodies.direct_stress[b] = {s.at[0][0][l], s.at[1][1][l], s.at[2][2][l]};
      bodies.shear_stress[b] = {s.at[1][2][l], s.at[2][0][l], s.at[0][1][l]};
      double* const out = reinterpret_cast<double*>(&responses[b]);
      for (int n = 0; n < 17; ++n) out[n] = answer[n][l];
      for (int n = 0; n < 3; ++n) out[17 + n] = bodies.velocity[b][n] + 0.5 * bodies.kick[b][n];
      out[20] = rows[b].place[3];
      out[21] = rows[b].motion[3] >= infinity;
      rows[b].place[3] = std::min(volume[l], rest_volume[b]);
      rows[b].motion[3] = bodies.damage[b] >= 1 ? infinity : bodies.pressure[b];
    }
  }
  return heat;
}

}  // namespace spall
