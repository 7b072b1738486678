// Reads [solver] of a case and of its phases: one line a key.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include "rigid/engine.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

using namespace dimension;

void read_solver(Section& in, SolverSettings& settings) {
  in.take("method", "", settings.method, solver_methods);
  in.take("friction", "", settings.friction, friction_models);
  in.take("tolerance", "on the residual, relative to that without impulses", settings.tolerance,
          positive(number));
  in.check("tolerance", settings.tolerance < 1,
           "must be less than 1: none at all is solved with 1");
  in.take("speed_tolerance",
          "on each contact's residual; by default `tolerance` of the fastest closing speed of an "
          "impact",
          settings.speed_tolerance, positive(speed));
  std::int64_t max_iterations = settings.max_iterations;
  in.take("max_iterations", "a step", max_iterations, 1);
  settings.max_iterations = static_cast<int>(std::min<std::int64_t>(max_iterations, 1 << 30));
  in.take("prox", "eps of the proximal Coulomb problem; 0: none", settings.prox,
          Quantity{number, 0, 1});
  in.take("relaxation", "of sor", settings.relaxation, Quantity{number, 0, 2, false});
  in.check("relaxation", settings.relaxation < 2, "must be less than 2");
}

void read(Section& in, EngineSettings& settings) {
  SolverSettings solver;
  in.table("solver", "of contact impulses", [&](Section& s) { read_solver(s, solver); });
  settings.set(solver);
}

void read_phase(Section& in, EngineSettings& settings) {
  auto solver = settings.get<SolverSettings>();
  in.table("solver", "where it differs from [solver]", [&](Section& s) { read_solver(s, solver); });
  settings.set(solver);
}

void check(const Surroundings& around, std::span<const MaterialUse>, const EngineSettings& settings,
           const PhaseView& phase) {
  require(around.cylinders.empty() && !around.period.any(),
          "{}: [[cylinders]] and [periodic] act in phases of method = \"penalty\", \"potential\" "
          "and \"solid\" only",
          phase.place);
  const auto solver = settings.get<SolverSettings>();
  require(
      !needs_convex(solver.method) || solver.friction == FrictionModel::convex ||
          !has_friction(around.contact),
      "{}: solver.method = \"apgd\" and \"bb\" minimise: with friction between bodies they need "
      "solver.friction = \"convex\"",
      phase.place);
  require(around.shapes.empty() || solver.method != SolverMethod::sor,
          "{}: solver.method = \"sor\" knows contacts of spheres alone, no [shapes]", phase.place);
}

FieldSet fields(const Surroundings& around, const EngineSettings&) {
  FieldSet fields{Field::angular_velocity, Field::acceleration};
  if (!around.shapes.empty()) fields |= {Field::shape, Field::orientation};
  return fields;
}

std::string describe(const Surroundings& around, std::span<const MaterialUse>,
                     const EngineSettings& settings) {
  const auto solver = settings.get<SolverSettings>();
  std::string text = has_friction(around.contact) || !around.shapes.empty()
                         ? ""
                         : "  no friction: one unknown a contact, no spins change\n";
  const SolverSettings usual;
  if (solver.relaxation != usual.relaxation && solver.method != SolverMethod::sor)
    text += "  solver.relaxation is not used: it is of solver.method = \"sor\"\n";
  if (solver.prox != usual.prox && solver.method != SolverMethod::accelerated)
    text += "  solver.prox is not used: it is of solver.method = \"accelerated\"\n";
  return text;
}

std::unique_ptr<Engine> make(const EngineSettings& settings) {
  return std::make_unique<Rigid>(settings.get<SolverSettings>());
}

}  // namespace

const EngineType rigid_engine{
    .name = "nonsmooth",
    .help = "rigid bodies with impacts, Coulomb friction and cohesion; impulses solved for",
    .deflects = true,
    .solves = true,
    .steps_a_keep = 50,
    .has_shapes = true,
    .moves_groups = true,
    .tables = {"contact", "solver"},
    .read = read,
    .read_phase = read_phase,
    .check = check,
    .fields = fields,
    .describe = describe,
    .make = make};

}  // namespace spall
