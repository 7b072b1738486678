// Bodies of solids that are worked on at once: laws, and what becomes of each by itself.
// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "pairs/flight.hpp"
#include "solid/bodies_step.hpp"
#include "solid/cold_curve.hpp"
#include "solid/flow_stress.hpp"
#include "solid/lane_eigen.hpp"
#include "solid_worlds.hpp"

namespace spall {
namespace {

constexpr double d = 1e-3;  // m
constexpr double h = 1e-8;  // s

SolidLaw law_of(const char* name) {
  return solid_law(*material_of_library(name).solid, true, name);
}

const Solid& copper() {
  static const Solid solid = *material_of_library("copper").solid;
  return solid;
}
const SolidLaw& ductile() {
  static const SolidLaw law = law_of("copper");
  return law;
}

TEST(ColdCurve, is_the_isentrope_that_touches_the_hugoniot_at_rest) {
  const ColdCurve curve(copper());
  for (double eta : {-0.02, -0.001, 1e-4, 0.01, 0.1, 0.3}) {
    const double de = 1e-6;
    const auto energy = [&](double e) { return curve.at(1 / (1 - e)).energy; };
    const double pressure = curve.at(1 / (1 - eta)).pressure;
    EXPECT_NEAR((energy(eta + de) - energy(eta - de)) / (2 * de), pressure,
                1e-6 * copper().bulk_modulus());
    // They differ by the heat of the shock, which is of third order.
    const double left = 1 - copper().hugoniot_slope * eta;
    const double hugoniot = copper().bulk_modulus() * eta / (left * left);
    const double third = copper().bulk_modulus() * std::abs(eta * eta * eta) / (left * left * left);
    EXPECT_LE(std::abs(hugoniot - pressure), 4 * third) << eta;
    // Sound is as fast as the Hugoniot's slope over density says.
    const auto shock = [](double density) {
      const double e = 1 - copper().density / density, rest = 1 - copper().hugoniot_slope * e;
      return copper().bulk_modulus() * e / (rest * rest);
    };
    const double density = copper().density / (1 - eta), step = 1e-5 * density;
    const double slope = (shock(density + step) - shock(density - step)) / (2 * step);
    EXPECT_NEAR(curve.at(1 / (1 - eta)).slope2, slope, 1e-6 * slope) << eta;
  }
}

TEST(SolidLaw, returns_to_the_flow_stress_of_each_metal) {
  SolidLaw other = ductile();
  other.steinberg = {.y0 = 0.8e9, .ymax = 1e9, .beta = 10, .n = 0.1};
  // The last two lanes are one body.
  const std::vector<SolidLaw> laws{ductile(), other};
  std::vector<std::int32_t> material(pair_lanes);
  for (std::size_t l = 0; l < pair_lanes; ++l) material[l] = static_cast<std::int32_t>(l % 2);
  std::vector<Index> bodies(pair_lanes - 1);
  std::iota(bodies.begin(), bodies.end(), 0);
  const LaneRows rows(bodies);
  const auto flow = [&](const SolidLaw& law, double strain, double rate, double hot) {
    if (law.steinberg.known()) return std::min(1e9, 0.8e9 * std::pow(1 + 10 * strain, 0.1));
    const double fast = 1 + 0.025 * std::log(std::max(1.0, rate)), soft = 1 - std::pow(hot, 1.09);
    return (90e6 + 292e6 * std::pow(strain, 0.31)) * fast * soft;
  };
  for (const auto& of : {std::vector<std::int32_t>(pair_lanes, 0), material})
    for (double hot : {0.0, 0.4})
      for (double strain : {0.0, 0.02, 1.5})
        for (double times : {0.9, 1.2, 2.0, 30.0}) {
          const LaneLaws lanes(laws, of, rows);
          const PairLanes all = spread_pairs(1);
          PairLanes trial;
          for (std::size_t l = 0; l < pair_lanes; ++l)
            trial[l] = times * flow(lanes[l], strain, 0, hot);
          const PairLanes x = plastic_increments(all > 0.0, flow_stress_of(lanes, hot * all),
                                                 ductile().shear * all, trial, strain * all, h);
          for (std::size_t l = 0; l < pair_lanes; ++l) {
            const double y = flow(lanes[l], strain + x[l], x[l] / h, hot);
            EXPECT_EQ(x[l] > 0, times > 1);
            const double left = trial[l] - 3 * ductile().shear * x[l];
            EXPECT_NEAR(left, times > 1 ? y : trial[l], 1e-8 * y);
          }
          EXPECT_EQ(x[pair_lanes - 1], x[pair_lanes - 2]);
        }
  EXPECT_EQ(flow_stress_of(ductile(), 1).at(0.3, 1e4).stress, 0);
  EXPECT_EQ(flow_stress_of(other, 1).at(0.3, 1e4).stress, 0);
}

TEST(ColdCurve, tells_its_own_slope) {
  Solid solid = copper();
  for (const double of_shock : {1e-4, 0.5, copper().hugoniot_slope}) {
    solid.hugoniot_slope = of_shock;
    const ColdCurve curve(solid);
    for (const double eta : {-0.2, -0.03, 0.0, 0.05, 0.3}) {
      const double step = 1e-5;
      const auto pressure = [&](double at) { return curve.at(1 / (1 - at)).pressure; };
      const double slope = (pressure(eta + step) - pressure(eta - step)) / (2 * step);
      EXPECT_NEAR(curve.at(1 / (1 - eta)).by_eta, slope, 1e-5 * slope) << eta;
    }
    EXPECT_EQ(curve.at(0.3).by_eta, 0);  // beyond the table
  }
}

TEST(ColdCurve, is_the_same_of_lanes) {
  const ColdCurve curve(copper());
  PairLanes at;
  for (std::size_t l = 0; l < pair_lanes; ++l) at[l] = 0.6 + 0.17 * static_cast<double>(l);
  const auto all = curve.at(at);
  for (std::size_t l = 0; l < pair_lanes; ++l) {
    const auto one = curve.at(at[l]);
    EXPECT_NEAR(all.pressure[l], one.pressure, 1e-14 * std::abs(one.pressure));
    EXPECT_NEAR(all.energy[l], one.energy, 1e-13 * std::abs(one.energy));
    EXPECT_NEAR(all.slope2[l], one.slope2, 1e-14 * one.slope2);
    EXPECT_NEAR(all.by_eta[l], one.by_eta, 1e-13 * std::abs(one.by_eta));
  }
}

// Any, of any size, with eigenvalues that are equal or zero, and nothing at all.
TEST(LaneEigen, has_the_eigenvalues_and_vectors_of_each_lane) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int trial = 0; trial < 200; ++trial) {
    LaneTensor t{};
    PairLanes values[3] = {};
    for (std::size_t l = 0; l < pair_lanes; ++l) {
      Mat3 any;
      for (int k = 0; k < 9; ++k) any(k / 3, k % 3) = uniform(random);
      const Mat3 turn = Eigen::HouseholderQR<Mat3>(any).householderQ();
      const double a = uniform(random), size = std::pow(10, 30 * uniform(random));
      const int kind = (trial + static_cast<int>(l)) % 5;
      const Vec3 value = size * (kind == 0   ? Vec3(a, uniform(random), uniform(random))
                                 : kind == 1 ? Vec3(a, a, uniform(random))
                                 : kind == 2 ? Vec3(a, a * (1 + 1e-9), 0)
                                 : kind == 3 ? Vec3(0, 0, a)
                                             : Vec3::Zero());
      const Mat3 whole = turn * value.asDiagonal() * turn.transpose();
      for (int i = 0; i < 3; ++i) {
        values[i][l] = value[i];
        for (int j = 0; j < 3; ++j) t.at[i][j][l] = (whole(i, j) + whole(j, i)) / 2;
      }
    }
    const LaneEigen found = eigen_of(t);
    const LaneTensor again = found.with(found.value), &v = found.vector;
    const LaneTensor one = v.transposed() * v;
    for (std::size_t l = 0; l < pair_lanes; ++l) {
      std::array<double, 3> right, got;
      for (int e = 0; e < 3; ++e) right[e] = values[e][l], got[e] = found.value[e][l];
      std::ranges::sort(right);
      std::ranges::sort(got);
      const double most = std::max(std::abs(right[0]), std::abs(right[2]));
      for (int i = 0; i < 3; ++i) {
        EXPECT_NEAR(got[i], right[i], 4e-15 * most);
        for (int j = 0; j < 3; ++j) {
          EXPECT_NEAR(again.at[i][j][l], t.at[i][j][l], 4e-15 * most);
          EXPECT_NEAR(one.at[i][j][l], i == j, 4e-15);
        }
      }
    }
  }
}

// --- a step of some bodies ---

/// Solids of many kinds, one of which rubs once it has failed.
const std::vector<SolidLaw>& kinds() {
  static const std::vector<SolidLaw> laws = [] {
    std::vector<SolidLaw> some;
    for (const char* name : {"copper", "aluminium_6061_t6", "tantalum", "basalt", "fused_silica",
                             "aluminium_porous", "aluminium_2024_t351"})
      some.push_back(law_of(name));
    some[1].rock.failed_friction = 0.4;
    return some;
  }();
  return laws;
}
constexpr Index rock = 3, glass = 4;

/// Bodies and what sweeps found around them.
struct Some {
  Bodies bodies;
  std::vector<ShapeRow> shapes;
  std::vector<MotionRow> rows;

  /// Those of these rows, in this order.
  Some of(const std::vector<Index>& from) const {
    Some some = *this;
    const auto take = [&](auto& numbers) {
      const auto all = numbers;
      for (std::size_t k = 0; k < from.size(); ++k) numbers[k] = all[from[k]];
      numbers.resize(from.size());
    };
    for_each_field(some.bodies, [&](const auto&, auto& field) { take(field); });
    take(some.shapes);
    take(some.rows);
    some.bodies.owned = static_cast<Index>(from.size());
    return some;
  }
};

/// Warm, strained, cracked, molten, at a surface: bodies drawn at random.
Some drawn(Index count) {
  Some some;
  Bodies& bodies = some.bodies;
  resize(bodies, count);
  bodies.owned = count;
  some.shapes.resize(count);
  some.rows.resize(count);
  std::mt19937_64 random(11);
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const auto vector = [&](double most) {
    return Vec3(between(-most, most), between(-most, most), between(-most, most));
  };
  for (Index b = 0; b < count; ++b) {
    const auto kind = static_cast<std::int32_t>(random() % kinds().size());
    const SolidLaw& law = kinds()[kind];
    const double cell = d * d * d / std::sqrt(2.0), pulled = between(-1, 1);
    bodies.id[b] = b;
    bodies.group[b] = 0;
    bodies.material[b] = kind;
    bodies.radius[b] = d / 2;
    bodies.mass[b] = law.density * cell;
    bodies.velocity[b] = vector(100);
    bodies.kick[b] = vector(1);
    bodies.compression[b] = 1 + 0.02 * pulled;
    bodies.pressure[b] = 0.02 * pulled * law.bulk;
    const Vec3 direct = vector(2e8);
    bodies.direct_stress[b] = direct - Vec3::Constant(direct.mean());
    bodies.shear_stress[b] = vector(2e8);
    bodies.plastic_strain[b] = b % 3 == 0 ? 0 : between(0, 0.3);
    bodies.damage[b] = b % 5 == 0 ? 1 : b % 5 == 1 ? between(0, 1) : 0;
    bodies.strained[b] = between(0, 1.5);
    bodies.crushed[b] = law.pores.any() ? between(0, 0.5) : 0;
    const double to_melt = std::min(1e6, law.melting_heat());
    bodies.heat[b] = (b % 4 == 0 ? 0 : between(0, 1.3)) * to_melt * bodies.mass[b];
    bodies.internal_energy[b] = bodies.heat[b] + between(0, 1e-3) * law.bulk * cell;
    // A flat body has no neighbours along an axis.
    Eigen::Matrix3d near = 20 * Eigen::Matrix3d::Identity(), turn;
    for (int k = 0; k < 3; ++k) near += 2 * vector(1) * vector(1).transpose();
    near = (near + near.transpose()).eval() / 2;
    if (b % 7 == 2) near.row(2) = near.col(2).transpose() = Vec3(0, 0, 0.5).transpose();
    for (int k = 0; k < 3; ++k) turn.row(k) = vector(1e6).transpose();
    const Eigen::Matrix3d K = d * d * cell * near, M = turn * K;
    some.shapes[b].at[0] = RowHalf{K(0, 0), K(1, 1), K(2, 2), K(1, 2)};
    some.shapes[b].at[1] = RowHalf{K(2, 0), K(0, 1), M(0, 0), M(0, 1)};
    some.shapes[b].at[2] = RowHalf{M(0, 2), M(1, 0), M(1, 1), M(1, 2)};
    some.shapes[b].at[3] = RowHalf{M(2, 0), M(2, 1), M(2, 2), K.trace() * between(-1e8, 1e8)};
    some.rows[b].place = RowHalf{0.0, 0.0, 0.0, cell};
    some.rows[b].motion = half_row(bodies.velocity[b], bodies.damage[b] >= 1 ? infinity : 0);
  }
  return some;
}

/// What became of them: the heat they gained, and how they answer.
struct Answer {
  double heat;
  std::vector<ResponseRow> responses;
};
Answer step(Some& some) {
  Answer answer{0, std::vector<ResponseRow>(some.rows.size())};
  std::vector<Index> all(some.rows.size());
  std::iota(all.begin(), all.end(), 0);
  answer.heat = update_bodies(some.bodies, kinds(), rest_volumes(some.bodies, kinds()), all, h,
                              h / 2, some.shapes.data(), some.rows.data(), answer.responses.data());
  return answer;
}

/// Of each field, by its name.
std::map<std::string, std::string> bytes_of(const Bodies& bodies) {
  std::map<std::string, std::string> bytes;
  for_each_field(bodies, [&](const auto& info, const auto& field) {
    bytes[info.name].assign(reinterpret_cast<const char*>(field.data()),
                            field.size() * sizeof(field[0]));
  });
  return bytes;
}

double mises_of(const Bodies& bodies, Index b) {
  const Vec3 &direct = bodies.direct_stress[b], &shear = bodies.shear_stress[b];
  return std::sqrt(1.5 * direct.squaredNorm() + 3 * shear.squaredNorm());
}

TEST(SolidBodies, become_what_they_become_alone_whoever_is_worked_on_beside_them) {
  const Index count = 200;
  const Some before = drawn(count);
  Some all = before.of([&] {
    std::vector<Index> rows(count - 3);  // the last lanes are filled up
    std::iota(rows.begin(), rows.end(), 0);
    return rows;
  }());
  const Answer together = step(all);
  double gained = 0, most = 0;
  for (Index b = 0; b < all.bodies.owned; ++b) {
    Some one = before.of({b});
    const Answer alone = step(one);
    const auto mine = bytes_of(one.bodies), its = bytes_of(all.of({b}).bodies);
    for (const auto& [name, bytes] : mine)
      EXPECT_TRUE(bytes == its.at(name)) << name << " of body " << b;
    EXPECT_EQ(std::memcmp(&alone.responses[0], &together.responses[b], sizeof(ResponseRow)), 0)
        << b;
    EXPECT_EQ(std::memcmp(&one.rows[0], &all.rows[b], sizeof(MotionRow)), 0) << b;
    const double own = all.bodies.heat[b] - before.bodies.heat[b];
    EXPECT_EQ(alone.heat, own);
    gained += own;
    most += std::abs(own);
  }
  EXPECT_NEAR(together.heat, gained, 1e-13 * most);
}

TEST(SolidBodies, bear_no_more_than_their_flow_stress_and_nothing_once_they_have_melted) {
  const Some before = drawn(300);
  Some after = before;
  step(after);
  int flowed = 0, molten = 0, rubbed = 0;
  for (Index b = 0; b < after.bodies.owned; ++b) {
    const Bodies &old = before.bodies, &bodies = after.bodies;
    const Index kind = bodies.material[b];
    if (kind == rock || kind == glass) continue;
    const SolidLaw& law = kinds()[kind];
    const double heat = old.heat[b] / bodies.mass[b], hot = heat / law.melting_heat();
    const double strained = bodies.plastic_strain[b] - old.plastic_strain[b];
    const double stiffness =
        law.steinberg.known() ? law.stiffness(old.compression[b], old.pressure[b], heat) : 1;
    const double bears = (1 - old.damage[b]) * stiffness;
    const double flow =
        bears * flow_stress_of(law, hot).at(bodies.plastic_strain[b], strained / h).stress;
    const double mises = mises_of(bodies, b);
    if (hot >= 1 || old.damage[b] >= 1) {
      const double slides = law.rock.failed_friction * std::max(0.0, old.pressure[b]);
      EXPECT_LE(mises, std::sqrt(3.0) * slides * (1 + 1e-12)) << b;
      EXPECT_EQ(mises > 0, slides > 0 && flow_stress_of(law, hot).at(0, 0).stress > 0) << b;
      ++(mises > 0 ? rubbed : molten);
    } else if (strained > 0 && bodies.damage[b] < 1) {
      EXPECT_NEAR(mises, flow, 1e-7 * flow) << b;
      ++flowed;
    } else if (bodies.damage[b] < 1) {
      EXPECT_LE(mises, flow * (1 + 1e-9)) << b;
    }
  }
  EXPECT_GT(flowed, 30);
  EXPECT_GT(molten, 30);
  EXPECT_GT(rubbed, 1);
}

TEST(SolidBodies, damp_by_the_speed_of_longitudinal_waves) {
  Some some = drawn(50);
  for (Index b = 0; b < some.bodies.owned; ++b) {
    Bodies& bodies = some.bodies;
    bodies.compression[b] = 1;
    bodies.pressure[b] = bodies.damage[b] = bodies.heat[b] = bodies.internal_energy[b] = 0;
    bodies.crushed[b] = 0;
    bodies.direct_stress[b] = bodies.shear_stress[b] = Vec3::Zero();
    some.shapes[b].at[1] = RowHalf{0.0, 0.0, 0.0, 0.0};
    some.shapes[b].at[2] = some.shapes[b].at[3] = RowHalf{0.0, 0.0, 0.0, 0.0};
  }
  const Answer answer = step(some);
  for (Index b = 0; b < some.bodies.owned; ++b) {
    const Index kind = some.bodies.material[b];
    if (kind == rock || kind == glass) continue;  // what is not sheared is a fluid there
    const SolidLaw& law = kinds()[kind];
    const auto& at = answer.responses[b].at;
    EXPECT_NEAR(at[3][3] / at[4][0], law.sound_speed() / law.slope, 1e-12 * law.sound_speed()) << b;
  }
}

}  // namespace
}  // namespace spall
