// A law of adhesion that is added as docs/how_to_add.md says: penalty contact, built again with one
// line more in its table.
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "penalty_worlds.hpp"
#include "scene/case.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

constexpr double c = 4e6;                     // J/m^3
constexpr double modulus = 1e8 / 0.9375 / 2;  // Pa, E* of two bodies of soft_rock
constexpr double radius = 0.5;                // m, R of two bodies of 1 m

const PenaltySettings by_area{.adhesion = Adhesion::contact_area, .adhesion_strength = c};

/// Two spheres of 1 m and 1000 kg at rest, pressed into each other.
Lab pressed(double overlap) {
  const double x = 1 - overlap / 2;
  return penalty_world(Comm(MPI_COMM_SELF),
                       {{.radius = 1, .mass = 1000, .position = {-x, 0, 0}},
                        {.radius = 1, .mass = 1000, .position = {x, 0, 0}}},
                       by_area, {.friction = 0.5, .restitution = 0.5});
}

/// N, from the speed after one short step from rest.
double force_at(double overlap) {
  Lab world = pressed(overlap);
  const double h = 1e-6;
  penalty_steps(world, h, 1);
  return 1000 * spheres_of(world)[1].velocity.x() / h;
}

TEST(AddedLaw, pulls_by_the_area_of_contact_and_lets_a_pair_rest_where_the_book_says) {
  const double a = 3 * std::numbers::pi * c * radius / (4 * modulus), rest = a * a / radius;
  const double scale = 4 / 3.0 * modulus * a * rest;
  for (double overlap : {0.1 * rest, 4 / 9.0 * rest, rest, 2 * rest}) {
    const double contact = std::sqrt(radius * overlap);
    const double force =
        4 / 3.0 * modulus * contact * overlap - c * std::numbers::pi * contact * contact;
    EXPECT_NEAR(force_at(overlap), force, 1e-9 * scale) << overlap / rest;
  }
  EXPECT_NEAR(force_at(rest), 0, 1e-9 * scale);
  // The strongest pull, where dF/ddelta = 0: at 4/9 of that overlap.
  EXPECT_NEAR(force_at(4 / 9.0 * rest), -c * std::numbers::pi * radius * rest * 4 / 27.0,
              1e-9 * scale);
}

TEST(AddedLaw, has_a_force_that_is_the_slope_of_its_energy) {
  const double overlap = 0.02, step = 1e-5;
  const auto energy_at = [](double at) {
    Lab world = pressed(at);
    return contact_energy(world);
  };
  const double slope = (energy_at(overlap + step) - energy_at(overlap - step)) / (2 * step);
  // Of second order in the step: the third derivative is some 1/overlap^2 of the force.
  EXPECT_NEAR(force_at(overlap), slope,
              (step * step / (overlap * overlap) + 1e-9) * modulus * overlap * overlap);
}

constexpr const char* grains = R"(
[materials.rock]
density = "1600 kg/m^3"
youngs_modulus = "100 MPa"
poisson_ratio = 0.25
[contact]
restitution = 0.5
[penalty]
adhesion = "contact_area"
{}
[[groups]]
name = "grain"
material = "rock"
volume = {{shape = "sphere", radius = "2 m"}}
packing = {{kind = "single"}}
[[phases]]
name = "rest"
method = "penalty"
step = "1 us"
duration = "1 ms"
)";

TEST(AddedLaw, is_chosen_and_told_by_the_keys_of_a_case) {
  EXPECT_NO_THROW(parse_case(fmt::format(grains, "cohesion_density = \"4 MJ/m^3\""), "x.toml", {}));
  try {
    parse_case(fmt::format(grains, "work_of_adhesion = \"1 J/m^2\""), "x.toml", {});
    ADD_FAILURE() << "a key of other laws is taken";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("x.toml:"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace spall
