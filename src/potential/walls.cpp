// Few bodies are at walls: one after another, by the formulas of single pairs.
// SPDX-License-Identifier: BSD-3-Clause
#include "potential/walls.hpp"

#include "pairs/flight.hpp"

namespace spall {
namespace {

const PairPotential& law_at(const World& world, const ByPair<PairPotential>& laws,
                            const AtWall& pair) {
  const int own = world.bodies.material[pair.row];
  const int of_wall = world.walls().material(static_cast<std::size_t>(pair.wall));
  return laws(own, of_wall == same_material ? own : of_wall);
}

/// Calls `f(pair, law, face, r)` for each body that is pressed against a wall.
template <class F>
void for_each_pressed(const World& world, const ByPair<PairPotential>& laws,
                      const std::vector<AtWall>& pairs, const PairRow* rows, F&& f) {
  const Walls walls = world.walls();
  for (const AtWall& pair : pairs) {
    const PairPotential& law = law_at(world, laws, pair);
    const Face face =
        face_of(walls, static_cast<std::size_t>(pair.wall), vector_of(rows[pair.row].place));
    const double r = face.height + law.distance / 2;
    if (r < law.distance) f(pair, law, face, r);
  }
}

}  // namespace

std::vector<AtWall> bodies_at_walls(const World& world, const ByPair<PairPotential>& laws,
                                    double skin) {
  const Walls walls = world.walls();
  std::vector<AtWall> near;
  for (std::size_t w = 0; w < walls.size(); ++w)
    for (Index b = 0; b < world.bodies.owned; ++b) {
      const AtWall pair{b, static_cast<std::int32_t>(w)};
      const double reach = law_at(world, laws, pair).distance / 2 + skin;
      if (face_of(walls, w, world.bodies.position[b]).height < reach) near.push_back(pair);
    }
  return near;
}

void push_from_walls(World& world, const ByPair<PairPotential>& laws,
                     const std::vector<AtWall>& pairs, double h, PairRow* rows) {
  for_each_pressed(world, laws, pairs, rows,
                   [&](const AtWall& pair, const PairPotential& law, const Face& face, double r) {
                     PairRow& row = rows[pair.row];
                     const Vec3 force = pair_force(law, r) * face.normal;
                     row.force += half_row(force, 0);
                     Reactions::at(world.reactions.of_walls, static_cast<std::size_t>(pair.wall))
                         .add(vector_of(row.place), -h * force);
                   });
}

double energy_at_walls(const World& world, const ByPair<PairPotential>& laws,
                       const std::vector<AtWall>& pairs, const PairRow* rows) {
  double energy = 0;
  for_each_pressed(world, laws, pairs, rows,
                   [&](const AtWall&, const PairPotential& law, const Face&, double r) {
                     energy += pair_energy(law, r) - pair_energy(law, law.distance);
                   });
  return energy;
}

}  // namespace spall
