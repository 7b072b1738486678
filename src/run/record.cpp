// Names of columns stand beside their values.
// SPDX-License-Identifier: BSD-3-Clause
#include "run/record.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace spall {

const std::vector<std::string> stages = {"gravity", "neighbours", "contacts", "solver",
                                         "forces",  "motion",     "output",   "analysis"};

namespace {

/// `f(name, unit, value)` for every column beside the stages' seconds.
template <class F>
void for_each_column(double phase, double contacts, const Balance& b, const StepReport& report,
                     double overlap, F&& f) {
  const Diagnostics& sums = b.sums;
  const SolverReport& solver = report.solver;
  auto vector = [&](const std::string& name, const char* unit, const Vec3& v) {
    for (int k = 0; k < 3; ++k) f(name + "_" + "xyz"[k], unit, v[k]);
  };
  f("phase", "", phase);
  f("contacts", "", contacts);
  f("kinetic", "J", sums.kinetic);
  f("gravitational", "J", b.gravitational);
  f("bonds", "J", b.bonds);
  f("dissipated", "J", sums.dissipated);
  f("corrections", "J", sums.corrections);
  f("prescribed_work", "J", sums.prescribed_work);
  f("unexplained", "J", b.unexplained_energy);
  vector("momentum", "kg m s-1", sums.momentum);
  vector("angular", "kg m+2 s-1", sums.angular_momentum);
  f("momentum_drift", "kg m s-1", b.momentum_drift);
  f("angular_drift", "kg m+2 s-1", b.angular_momentum_drift);
  f("rms_speed", "m s-1", sums.rms_speed);
  f("gyration_radius", "m", sums.gyration_radius);
  f("residual", "", solver.residual);
  f("residual_prox", "", solver.residual_prox);
  f("residual_max", "m s-1", solver.residual_max);
  f("residual_rms", "m s-1", solver.residual_rms);
  f("products", "", static_cast<double>(solver.products));
  f("corrections_products", "", static_cast<double>(report.correction_products));
  f("overlap", "", overlap);
}

}  // namespace

void Record::book(const StepReport& report, bool solved) {
  solved_ += solved ? 1 : 0;
  products_ += report.solver.products;
  correction_products_ += report.correction_products;
  residual_max_ = std::max(residual_max_, report.solver.residual_max);
  squares_ += report.solver.residual_rms * report.solver.residual_rms;
  worst_relative_ = std::max(worst_relative_, report.solver.residual);
  unconverged_ += report.solver.converged ? 0 : 1;
  over_tolerance_ += report.solver.over_tolerance ? 1 : 0;
  relaxed_ += report.solver.relaxed ? 1 : 0;
  withheld_ += report.withheld;
  double& overlap = solved ? overlap_ : soft_overlap_;
  overlap = std::max(overlap, report.overlap);
}

void Record::save(Scalars& scalars) const {
  save_scalars(*this, scalars);
  scalars["record.overlap"] = overlap_;
  scalars["record.soft_overlap"] = soft_overlap_;
  scalars["record.withheld"] = withheld_;
}
void Record::load(const Scalars& scalars) {
  load_scalars(*this, scalars);
  const auto take = [&](const char* name, double& value) {
    if (scalars.contains(name)) value = find_scalar(scalars, name);  // files of before have none
  };
  take("record.overlap", overlap_);
  take("record.soft_overlap", soft_overlap_);
  take("record.withheld", withheld_);
}

std::vector<Column> Record::columns() {
  std::vector<Column> columns;
  for_each_column(0, 0, {}, {}, 0, [&](const std::string& name, const char* unit, double) {
    columns.push_back({name, unit});
  });
  for (const auto& stage : stages) columns.push_back({"seconds_" + stage, "s"});
  return columns;
}

std::vector<double> Record::row(std::int64_t phase, std::int64_t contacts, const Balance& balance,
                                const StepReport& report, double overlap, const StageUses& uses) {
  std::vector<double> values;
  for_each_column(static_cast<double>(phase), static_cast<double>(contacts), balance, report,
                  overlap,
                  [&](const std::string&, const char*, double value) { values.push_back(value); });
  for (const auto& stage : stages) values.push_back(uses.at(stage).seconds);
  return values;
}

std::string Record::warning(double dissipated) const {
  constexpr double seen = 0.05;  // as energy that no entry explains
  if (withheld_ <= seen * std::max(dissipated, 0.0)) return "";
  return fmt::format(
      "hits that restitution would have left up to {:.2g} J, beside {:.2g} J that were dissipated, "
      "did not bounce: gravity drives some body as fast within a step, though not these. Shorter "
      "steps let slower hits bounce",
      withheld_, dissipated);
}

void Record::add_to(ResultTable& table, std::int64_t steps, bool solves) const {
  table.add("solver", "steps", steps);
  if (soft_overlap_ > 0)
    table.add("penalty", "overlap_max", soft_overlap_, "", "of all steps, over the smaller radius");
  if (!solves) return;
  const double count = std::max(solved_, 1.0);
  table.add("solver", "solved_steps", static_cast<std::int64_t>(solved_), "",
            "of them, by a method that solves for impulses");
  table.add("solver", "overlap_max", overlap_, "", "of all steps, over the smaller radius");
  table.add("solver", "residual_max", residual_max_, "m/s", "largest of all contacts and steps");
  table.add("solver", "residual_rms", std::sqrt(squares_ / count), "m/s",
            "over contacts and solved steps");
  table.add("solver", "residual_relative", worst_relative_, "", "largest E of a step");
  table.add("solver", "products", static_cast<std::int64_t>(products_));
  table.add("solver", "products_a_step", products_ / count, "", "solved");
  table.add("solver", "steps_not_converged", static_cast<std::int64_t>(unconverged_));
  table.add("solver", "steps_over_tolerance", static_cast<std::int64_t>(over_tolerance_), "",
            "whose residual, without the proximal term, missed the tolerance");
  table.add("solver", "steps_relaxed", static_cast<std::int64_t>(relaxed_), "",
            "that found impulses by convex friction alone");
  table.add("solver", "correction_products", static_cast<std::int64_t>(correction_products_));
  if (withheld_ > 0)
    table.add("solver", "withheld", withheld_, "J",
              "at most: what restitution would have left hits slower than 2 h g, g the largest");
}

}  // namespace spall
