// Collects at fixed times, because dv keeps rising while ejecta leave.
// SPDX-License-Identifier: BSD-3-Clause
#include "run/verdict.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "scene/orbit.hpp"

namespace spall {

namespace {

/// What crossed from the formulas to the bodies.
void add_flow(const HandOver& flow, double unit, ResultTable& table) {
  const auto add = [&](const char* key, double value, const char* of, const char* note) {
    table.add("coupling", key, value, of, note);
  };
  add("impactor_radius", flow.a, "m", "");
  add("impactor_density", flow.delta, "kg/m^3", "");
  add("hand_over", flow.hand_over, "m", "from there on bodies got the flow");
  add("reach", flow.reach, "m", "to there");
  add("bodies", flow.count, "", "that got some of it");
  add("inner_mass", flow.inner_mass, "kg", "launched within, by the formulas; stays with bodies");
  add("inner_momentum", flow.inner_momentum / unit, "m U",
      "against the flight; leaves with the impactor's body");
  add("inner_energy", flow.inner_energy / flow.energy, "m U^2/2", "of that mass, by the formulas");
  add("outer_mass", flow.outer_mass, "kg", "launched beyond, by the formulas");
  add("outer_momentum", flow.outer_momentum / unit, "m U", "the sum of sizes");
  add("outer_energy", flow.outer_energy / flow.energy, "m U^2/2", "");
  add("found_mass", flow.found_mass, "kg", "of bodies where that is launched");
  add("given_momentum", flow.given_momentum / unit, "m U", "that these got, against the flight");
  add("flow_energy", flow.flow_energy / flow.energy, "m U^2/2", "that bodies of the target got");
  add("carrier_energy", flow.carrier_energy / flow.energy, "m U^2/2",
      "that the impactor's body has with the inner momentum");
  add("heat", flow.heat, "J", "the rest of the impactor's energy, booked as dissipated");
  add("momentum_closure", flow.momentum_closure, "m U", "open after the recoil");
  add("angular_closure", flow.angular_closure, "m U times the target's reach", "the same");
}

}  // namespace

void Verdict::look_at_pile(const World& world) {
  if (world.period.any()) return;  // space that repeats itself has no pile: where would it begin?
  pile_ = measure_interior(world.comm, world.bodies, std::vector<char>(world.bodies.owned, 1),
                           world.shapes);
}

std::string Verdict::impactor_added(const PhaseEvents& events, double restitution,
                                    double struck_mass) {
  before_ = events.before;
  flow_ = events.flow;
  before_.struck = events.aim ? events.aim->struck : -1;
  before_.struck_mass = flow_ ? 0 : struck_mass;
  restitution_ = restitution;
  rows_.clear();
  faster_.clear();
  if (before_.struck_mass == 0) return "";
  return fmt::format(
      "a rigid hit leaves {:.2g} % of its energy in that body of {:.4g} kg; ejecta and beta follow "
      "this share",
      100 * rigid_share(before_, restitution), struck_mass);
}

namespace {

/// m^3/(kg s^2), by which pieces may be bound: 0 where bodies do not attract each other.
double binding_constant(const World& world) {
  return world.gravity.method == GravityMethod::none ? 0 : world.gravity.constant;
}

}  // namespace

void Verdict::look_at_target(const World& world, const Engine& engine) {
  const LinkedBodies linked = engine.links(world);
  const Deflection d = measure_deflection(world.comm, linked.ghosts, linked.bodies, linked.links,
                                          binding_constant(world), before_);
  before_.stirred = d.clump.mass * d.dv_vector.norm();
  has_struck_ = d.has_struck;
}

std::string Verdict::read_out(const World& world, const Engine& engine, double since_impact) {
  const LinkedBodies linked = engine.links(world);
  const Deflection d = measure_deflection(world.comm, linked.ghosts, linked.bodies, linked.links,
                                          binding_constant(world), before_);
  rows_.push_back({.since_impact = since_impact,
                   .dv = d.dv,
                   .beta = d.beta,
                   .beta_along = d.beta_along,
                   .clump_mass = d.clump.mass,
                   .clump_count = static_cast<double>(d.clump.count),
                   .ejecta_count = static_cast<double>(d.ejecta.count),
                   .ejecta_mass = d.ejecta.mass,
                   .v_ejecta = d.ejecta.v_ejecta,
                   .back_momentum = d.ejecta.back_momentum,
                   .fastest = d.ejecta.fastest,
                   .cone_half = d.ejecta.cone_half,
                   .cone_most = d.ejecta.cone_most,
                   .dv_impactor = d.dv_impactor,
                   .dv_rebound = d.dv_rebound,
                   .dv_ejecta = d.dv_ejecta,
                   .closure = d.closure});
  faster_ = d.ejecta.faster;
  closure_ = std::max(closure_, d.closure);
  return fmt::format(
      "read-out at {:.4g} s after the impact: dv {:.5g} m/s (impactor {:.5g}, rebound {:.5g}, "
      "ejecta {:.5g}), beta {:.4g}, {} ejecta of {:.4g} kg",
      since_impact, d.dv, d.dv_impactor, d.dv_rebound, d.dv_ejecta, d.beta, d.ejecta.count,
      d.ejecta.mass);
}

namespace {

constexpr double resolved = 0.02;  // of m U: less is not looked at
constexpr double shattered = 0.5;  // of the mass: the usual bound of catastrophic disruption

}  // namespace

std::string Verdict::foreign_motion() const {
  if (rows_.empty() || flow_) return "";
  if (!of_scene_.empty()) return of_scene_;
  if (before_.stirred <= resolved * impactor_momentum()) return "";
  return fmt::format(
      "before the impact the largest clump of the target already had {:.2g} of m U against the "
      "rest of it: dv, beta and ejecta count that as the impact's. They are of one body, or of a "
      "pile that hangs together and rests",
      before_.stirred / impactor_momentum());
}

std::string Verdict::warning() const {
  if (const std::string told = foreign_motion(); !told.empty()) return "WARNING: " + told;
  if (rows_.empty()) return "";
  const Row& last = rows_.back();
  if (last.clump_mass < shattered * before_.target_mass)
    return fmt::format(
        "WARNING: the target is shattered: its largest clump has {:.2g} of its mass. dv, beta and "
        "an orbit are those of this remnant, which say nothing of the target as a whole",
        last.clump_mass / before_.target_mass);
  if (!has_struck_)
    return fmt::format(
        "WARNING: dv, beta and ejecta are of the largest clump, {:.4g} kg, which the body that was "
        "hit did not belong to: it counts as an ejectum",
        last.clump_mass);
  if (flow_ || before_.struck_mass == 0) return "";
  if (last.dv_ejecta > resolved * last.dv_impactor) {
    if (std::isfinite(last.beta)) return "";
    return fmt::format(
        "WARNING: no beta: what left flies across the flight, more than 60 degrees beside it both "
        "ways. beta_along, {:.4g}, is along the flight alone",
        last.beta_along);
  }
  const double share = last.dv_ejecta / last.dv_impactor;
  const std::string why =
      share < -resolved
          ? fmt::format(
                "less than a bounce alone would give: what left forwards took {:.2g} of m U",
                -share)
          : fmt::format("that of a bounce alone, 1 + e at most: ejecta brought {:.2g} of m U",
                        share);
  return fmt::format(
      "WARNING: beta {:.4g} is {}. The body that was hit weighs {:.3g} impactors, so nothing of a "
      "crater is resolved. Bodies lighter than the impactor at the site, or impactor.coupling, "
      "would tell of ejecta",
      last.beta_along, why, before_.struck_mass / before_.impactor_mass);
}

void Verdict::add_to(ResultTable& table, const std::optional<Binary>& binary) const {
  if (pile_.mass > 0) {
    table.add("pile", "mass", pile_.mass, "kg");
    table.add("pile", "packing_fraction", pile_.packing_fraction, "",
              "inside the half-mass radius");
    table.add("pile", "half_mass_radius", pile_.half_mass_radius, "m");
    table.add("pile", "mean_diameter", pile_.mean_diameter, "m", "mean over all directions");
    table.add("pile", "extent", pile_.extent, "m", "largest distance between two points");
    table.add("pile", "axes", std::vector<double>(pile_.axes.data(), pile_.axes.data() + 3), "m",
              "of the ellipsoid with the same moments");
    table.add("pile", "gyration_radius", pile_.gyration_radius, "m");
  }
  if (rows_.empty()) return;
  const Row& last = rows_.back();
  const double without_ejecta = impactor_momentum() / before_.target_mass;
  table.add("deflection", "since_impact", last.since_impact, "s");
  table.add("deflection", "dv", last.dv, "m/s",
            "of the largest clump, along the flight of the impactor");
  table.add("deflection", "dv_impactor", last.dv_impactor, "m/s", "what m U brought");
  table.add("deflection", "dv_rebound", last.dv_rebound, "m/s", "what the impactor took back");
  table.add("deflection", "dv_ejecta", last.dv_ejecta, "m/s", "what the ejecta took");
  table.add("deflection", "dv_plastic", without_ejecta, "m/s",
            "m v / M: impactor stuck, no ejecta");
  table.add("deflection", "dv_elastic", without_ejecta * (1 + restitution_), "m/s",
            "m v (1 + e) / M: impactor rebounds, no ejecta");
  table.add("deflection", "beta", last.beta, "",
            "vector formula of Cheng et al. 2023; nan: what left flies across the flight");
  table.add("deflection", "beta_along", last.beta_along, "", "M dv / (m v)");
  table.add("deflection", "momentum_closure", closure_, "", "largest of all read-outs, of m v");
  if (before_.struck_mass > 0) {
    table.add("deflection", "struck_mass", before_.struck_mass, "kg",
              "of the body that the impactor met first");
    table.add("deflection", "rigid_share", rigid_share(before_, restitution_), "",
              "of the impactor's energy, left in it by a rigid head-on hit: beta follows it");
  }
  if (flow_) add_flow(*flow_, impactor_momentum(), table);
  if (const std::string told = warning(); !told.empty()) table.add("deflection", "warning", told);
  if (const std::string told = foreign_motion(); !told.empty())
    table.add("deflection", "foreign_motion", told);
  if (binary) {
    const Orbit orbit = new_orbit(*binary, last.dv);
    table.add("deflection", "a_new", orbit.a_new, "m",
              orbit.a_new > 0 ? "" : "negative: the target escapes from its primary");
    table.add("deflection", "T_new_min", orbit.T_new / 60, "min");
    table.add("deflection", "dT_min", orbit.dT / 60, "min");
  }
  table.add("clump", "count", static_cast<std::int64_t>(last.clump_count));
  table.add("clump", "mass", last.clump_mass, "kg");
  table.add("ejecta", "count", static_cast<std::int64_t>(last.ejecta_count));
  table.add("ejecta", "mass", last.ejecta_mass, "kg");
  table.add("ejecta", "v_ejecta", last.v_ejecta, "m/s", "sum of the speeds against the flight");
  table.add("ejecta", "back_momentum", last.back_momentum, "kg m/s", "the same, weighted by mass");
  table.add("ejecta", "fastest", last.fastest, "m/s");
  table.add("ejecta", "cone_half_deg", last.cone_half, "deg",
            "half-aperture with half the momentum");
  table.add("ejecta", "cone_most_deg", last.cone_most, "deg", "half-aperture with 90 % of it");
  const auto column_of = [](const auto& rows, auto member) {
    std::vector<double> values;
    for (const auto& row : rows) values.push_back(row.*member);
    return values;
  };
  if (!faster_.empty()) {
    table.add("ejecta", "speeds", column_of(faster_, &FasterThan::speed), "m/s");
    table.add("ejecta", "count_faster", column_of(faster_, &FasterThan::count), "",
              "bodies faster than each of speeds");
    table.add("ejecta", "mass_faster", column_of(faster_, &FasterThan::mass), "kg",
              "mass faster than each of speeds");
  }
  const auto column = [&](auto member) { return column_of(rows_, member); };
  table.add("read_out", "since_impact", column(&Row::since_impact), "s");
  table.add("read_out", "dv", column(&Row::dv), "m/s");
  table.add("read_out", "beta", column(&Row::beta));
  table.add("read_out", "ejecta_count", column(&Row::ejecta_count));
  table.add("read_out", "ejecta_mass", column(&Row::ejecta_mass), "kg");
  table.add("read_out", "v_ejecta", column(&Row::v_ejecta), "m/s");
}

template <class Self, class F>
void Verdict::for_each_scalar(Self& self, F&& f) {
  auto vector = [&](const std::string& name, auto& v) {
    for (int k = 0; k < 3; ++k) f(name + "." + std::to_string(k), v[k]);
  };
  f("verdict.impactor_mass", self.before_.impactor_mass);
  f("verdict.target_mass", self.before_.target_mass);
  f("verdict.struck_mass", self.before_.struck_mass);
  f("verdict.stirred", self.before_.stirred);
  vector("verdict.target_velocity", self.before_.target_velocity);
  vector("verdict.relative_velocity", self.before_.relative_velocity);
  f("verdict.restitution", self.restitution_);
  f("verdict.closure", self.closure_);
  f("verdict.pile.mass", self.pile_.mass);
  f("verdict.pile.gyration_radius", self.pile_.gyration_radius);
  f("verdict.pile.half_mass_radius", self.pile_.half_mass_radius);
  f("verdict.pile.packing_fraction", self.pile_.packing_fraction);
  f("verdict.pile.extent", self.pile_.extent);
  f("verdict.pile.mean_diameter", self.pile_.mean_diameter);
  vector("verdict.pile.axes", self.pile_.axes);
  if (self.flow_) HandOver::for_each_scalar(*self.flow_, f);
  for (std::size_t k = 0; k < self.faster_.size(); ++k) {
    f(fmt::format("verdict.faster.{}.speed", k), self.faster_[k].speed);
    f(fmt::format("verdict.faster.{}.count", k), self.faster_[k].count);
    f(fmt::format("verdict.faster.{}.mass", k), self.faster_[k].mass);
  }
  for (std::size_t r = 0; r < self.rows_.size(); ++r) {
    auto& row = self.rows_[r];
    int k = 0;
    for (auto* value : {&row.since_impact, &row.dv, &row.beta, &row.beta_along, &row.clump_mass,
                        &row.clump_count, &row.ejecta_count, &row.ejecta_mass, &row.v_ejecta,
                        &row.back_momentum, &row.fastest, &row.cone_half, &row.cone_most,
                        &row.dv_impactor, &row.dv_rebound, &row.dv_ejecta, &row.closure})
      f(fmt::format("verdict.read_out.{}.{}", r, k++), *value);
  }
}

void Verdict::save(Scalars& scalars) const {
  scalars["verdict.has_flow"] = flow_ ? 1 : 0;
  scalars["verdict.impactor"] = static_cast<double>(before_.impactor);
  scalars["verdict.has_struck"] = has_struck_ ? 1 : 0;
  scalars["verdict.read_outs"] = static_cast<double>(rows_.size());
  scalars["verdict.speeds"] = static_cast<double>(faster_.size());
  save_scalars(*this, scalars);
}

void Verdict::load(const Scalars& scalars) {
  before_.impactor = static_cast<BodyId>(find_scalar(scalars, "verdict.impactor"));
  rows_.resize(static_cast<std::size_t>(find_scalar(scalars, "verdict.read_outs")));
  const auto known = [&](const char* name, double otherwise) {  // files of before lack some
    const auto found = scalars.find(name);
    return found == scalars.end() ? otherwise : found->second;
  };
  has_struck_ = known("verdict.has_struck", 1) != 0;
  if (known("verdict.has_flow", 0) != 0) flow_.emplace();
  faster_.resize(static_cast<std::size_t>(known("verdict.speeds", 0)));
  load_scalars(*this, scalars);
}

}  // namespace spall
