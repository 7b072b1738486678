// Drift h/2, forces, kick h, drift h/2; where nothing is asked for in between, the drifts of two
// steps, each rounded as if alone, follow on the kick while the body is in the cache.
// SPDX-License-Identifier: BSD-3-Clause
#include "potential/step.hpp"

#include <algorithm>
#include <cmath>

#include "base/kernels.hpp"
#include "engine/prescribed.hpp"
#include "pairs/flight.hpp"
#include "potential/laws.hpp"
#include "potential/walls.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

/// Rounded once, whatever stands around it: a compiler may fuse a product and a sum or not.
void drift(PairRow& row, const RowHalf& velocity, double h) {
  row.place = multiply_add(h, RowHalf{velocity[0], velocity[1], velocity[2], 0}, row.place);
}

bool is_damped(const ByPair<PairPotential>& laws) {
  return laws.any([](const PairPotential& p) { return p.damping > 0; });
}
bool has_embedding(const ByPair<PairPotential>& laws) {
  return laws.any([](const PairPotential& p) { return p.embedding.bulk_modulus > 0; });
}

void fill_rows(const World& world, Potential& engine) {
  const Bodies& bodies = world.bodies;
  engine.rows.resize(bodies.size());
  for (Index b = 0; b < bodies.size(); ++b)
    engine.rows[b] = {half_row(bodies.position[b], 1 / bodies.mass[b]), RowHalf{}};
  if (!is_damped(engine.law)) return;
  engine.ahead.resize(bodies.size());
  for (Index b = 0; b < bodies.size(); ++b)
    engine.ahead[b] = bodies.velocity[b] + bodies.kick[b] / 2;
}

void take_positions(World& world, const Potential& engine) {
  Bodies& bodies = world.bodies;
  for (Index b = 0; b < bodies.owned; ++b) bodies.position[b] = vector_of(engine.rows[b].place);
}

void take_rows(World& world, const Potential& engine) {
  Bodies& bodies = world.bodies;
  take_positions(world, engine);
  if (!is_damped(engine.law)) return;
  for (Index b = 0; b < bodies.owned; ++b)
    bodies.kick[b] = 2 * (engine.ahead[b] - bodies.velocity[b]);
}

/// m, up to which two bodies may act on each other.
double reach_of(const ByPair<PairPotential>& laws) {
  const double crowding = has_embedding(laws) ? crowding_reach : 0;
  double reach = 0;
  laws.for_each([&](const PairPotential& p) {
    reach = std::max({reach, p.cutoff, crowding * p.distance});
  });
  return reach;
}

/// Where bonds break, bodies of one group are bound, or of two where the law says so.
BondReach bonds_to_make(const World& world, const ByPair<PairPotential>& laws) {
  if (!laws.any([](const PairPotential& p) { return p.breaking_strain > 0; })) return {};
  return [&](Index i, Index j) {
    const Bodies& bodies = world.bodies;
    const PairPotential& p = laws(bodies.material[i], bodies.material[j]);
    const bool may = p.bonds_groups || bodies.group[i] == bodies.group[j];
    return p.breaking_strain > 0 && may ? p.cutoff : 0.0;
  };
}

/// Makes pairs and ghosts current for forces at the present positions.
void update_pairs(World& world, Potential& engine, bool velocities) {
  StageTimer timer(world.stages, "neighbours");
  NearPairs& near = engine.near;
  near.cut = world.cut;
  if (near.skin > 0 && near.moved > near.skin) {
    take_positions(world, engine);
    near.moved = approach_since_search(world, near);
  }
  if (near.skin == 0 || near.moved > near.skin) {
    double spacing = 0;
    engine.law.for_each([&](const PairPotential& p) { spacing = std::max(spacing, p.distance); });
    const double skin =
        best_skin(world.comm, world.bodies, near, {}, near.reach, skins_of_lattice(spacing));
    take_rows(world, engine);
    wrap_bodies(world);
    search_near_pairs(world.comm, world.bodies, world.period, {reach_of(engine.law)}, skin,
                      bonds_to_make(world, engine.law), near);
    engine.at_walls = bodies_at_walls(world, engine.law, near.skin);
    fill_rows(world, engine);
    return;
  }
  ++near.steps;
  // Forces are zero between sweeps, and so those of ghosts become zero again.
  double* const rows = reinterpret_cast<double*>(engine.rows.data());
  if (velocities)
    near.ghosts.gather({{rows, doubles_a_row}, {flat(engine.ahead), 3}});
  else
    near.ghosts.gather(rows, doubles_a_row);
  if (world.period.any())
    for (Index g = 0; g < near.ghosts.ghosts(); ++g)
      engine.rows[world.bodies.owned + g].place += half_row(near.shifts[g], 0);
}

/// Bodies are told apart by their material, or not where one law serves all.
std::size_t kind_of(const World& world, const ByPair<PairPotential>& laws, Index b) {
  return laws.uniform() ? 0 : static_cast<std::size_t>(world.bodies.material[b]);
}

/// kg, of the lightest body of each kind that moves, over all ranks; infinity without any.
/// Collective.
std::vector<double> lightest_bodies(const World& world, const ByPair<PairPotential>& laws) {
  std::vector<double> negative(std::max(1, laws.materials()), -infinity);
  for (Index b = 0; b < world.bodies.owned; ++b) {
    double& most = negative[kind_of(world, laws, b)];
    most = std::max(most, -world.bodies.mass[b]);
  }
  world.comm.max(negative);
  for (double& mass : negative) mass = -mass;
  return negative;
}

/// kg, of a kind of bodies over all ranks. What is held has no mass.
struct Masses {
  double lightest = infinity;
  double heaviest = 0, next = 0;  ///< of those that move; 0 without any
  bool held = false;

  bool any() const { return held || heaviest > 0; }
  /// Most that two of them have, or one of them and one of others.
  double reduced() const { return held ? heaviest : reduced(heaviest, next); }
  double reduced(const Masses& other) const {
    if (held || other.held) return std::max(held ? other.heaviest : 0, other.held ? heaviest : 0);
    return reduced(heaviest, other.heaviest);
  }

 private:
  static double reduced(double a, double b) { return a > 0 && b > 0 ? 1 / (1 / a + 1 / b) : 0; }
};

/// Of each kind. Collective.
std::vector<Masses> masses_of(const World& world, const ByPair<PairPotential>& laws) {
  const std::vector<double> lightest = lightest_bodies(world, laws);
  std::vector<double> heaviest(lightest.size(), 0), next = heaviest, held = heaviest;
  for (Index b = 0; b < world.bodies.owned; ++b) {
    const std::size_t k = kind_of(world, laws, b);
    double mass = world.bodies.mass[b];
    if (std::isinf(mass)) {
      held[k] = 1;
      continue;
    }
    if (mass > heaviest[k]) std::swap(mass, heaviest[k]);
    next[k] = std::max(next[k], mass);
  }
  std::vector<double> most = heaviest, ranks(most.size());  // ranks that have one of the heaviest
  world.comm.max(most);
  for (std::size_t k = 0; k < most.size(); ++k) {
    ranks[k] = heaviest[k] == most[k] ? 1 : 0;
    if (heaviest[k] < most[k]) next[k] = heaviest[k];
  }
  world.comm.sum(std::span<double>(ranks));
  world.comm.max(next);
  world.comm.max(held);
  std::vector<Masses> all;
  for (std::size_t k = 0; k < most.size(); ++k)
    all.push_back({lightest[k], most[k], ranks[k] > 1 ? most[k] : next[k], held[k] > 0});
  return all;
}

/// kg/s, c of the force -c u_n along the line of the centres that damps a pair. Collective.
ByPair<double> damping_of(const World& world, const ByPair<PairPotential>& laws) {
  if (!is_damped(laws)) return 0.0;
  require(world.bodies.has(Field::heat) && world.bodies.has(Field::kick),
          "damping needs fields that the bodies were made without");
  const auto c = [](const PairPotential& p, double mass) {
    return p.damping * std::sqrt(2 * stiffness(p) * mass);
  };
  const std::vector<double> lightest = lightest_bodies(world, laws);
  if (laws.uniform()) return c(laws.common(), lightest[0]);
  ByPair<double> of_pairs(laws.materials(), 0);
  for (int a = 0; a < laws.materials(); ++a)
    for (int b = 0; b <= a; ++b) {
      const double mass = std::min(lightest[a], lightest[b]);
      if (laws(a, b).given() && std::isfinite(mass)) of_pairs.set(a, b, c(laws(a, b), mass));
    }
  return of_pairs;
}

/// Calls `f` with the terms that sweeps go over pairs with.
template <class F>
auto with_terms(const World& world, const Potential& engine, const ByPair<double>& damping, F&& f) {
  if (engine.law.uniform()) {
    const PairPotential& p = engine.law.common();
    return with_law(p, [&](const auto& law) { return f(OneLaw(p, law, damping.common())); });
  }
  const LawTable table(engine.law, damping);
  const std::int32_t* material = world.bodies.material.data();
  return engine.near.bonds_break ? f(MixedLaws<true>(table, material))
                                 : f(MixedLaws<false>(table, material));
}

/// The embedding of each material's own law.
class Embeddings {
 public:
  explicit Embeddings(const ByPair<PairPotential>& laws) {
    if (!has_embedding(laws)) return;
    for (int m = 0; m < std::max(1, laws.materials()); ++m) {
      const PairPotential& own = laws(m, m);
      of_materials_.emplace_back();
      if (own.embedding.bulk_modulus > 0) of_materials_.back().emplace(own);
    }
  }
  bool any() const { return !of_materials_.empty(); }
  /// Null where pairs are all there is.
  const EmbeddingLaw* of(std::int32_t material) const {
    const auto m = of_materials_.size() == 1 ? 0 : static_cast<std::size_t>(material);
    return of_materials_[m] ? &*of_materials_[m] : nullptr;
  }

 private:
  std::vector<std::optional<EmbeddingLaw>> of_materials_;  // one: of all
};

/// The crowding of the owned bodies at the present positions.
void measure_crowding(const World& world, Potential& engine) {
  engine.crowding.assign(engine.rows.size(), 0.0);
  const auto sweep = [&](const auto& terms) {
    sweep_crowding(engine.near.windows, terms, engine.rows.data(), engine.crowding.data());
  };
  if (engine.law.uniform())
    sweep(OneCrowding(crowding_reach * engine.law.common().distance));
  else
    with_terms(world, engine, 0.0, sweep);
}

/// What bodies press with at the present positions; ghosts learn it from their ranks.
void update_pushes(World& world, Potential& engine, const Embeddings& laws) {
  StageTimer timer(world.stages, "forces");
  measure_crowding(world, engine);
  const Bodies& bodies = world.bodies;
  engine.pushes.resize(bodies.size());
  const bool damped = is_damped(engine.law);  // or heat's work would not be booked
  for (Index b = 0; b < bodies.owned; ++b) {
    const EmbeddingLaw* law = laws.of(bodies.material[b]);
    engine.pushes[b] = {};
    if (!law) continue;
    const double volume = law->volume(bodies.mass[b]);
    const double heat = damped ? bodies.heat[b] / volume : 0;
    const auto [all, hot] = law->push(engine.crowding[b], heat);
    engine.pushes[b] = {volume * all, volume * hot};
  }
  engine.near.ghosts.gather(reinterpret_cast<double*>(engine.pushes.data()), doubles_a_push);
}

/// Forces at the present positions, the kick by them over `h`, and drifts over two times, of which
/// the second may be none.
RowBox kick_and_drift(World& world, Potential& engine, const ByPair<double>& damping, double h,
                      double first, double second) {
  StageTimer timer(world.stages, "forces");
  PairRow* const rows = engine.rows.data();
  Vec3* const velocity = world.bodies.velocity.data();
  Vec3* const ahead = engine.ahead.data();
  double* const heat = world.bodies.heat.data();
  const bool is_damped = spall::is_damped(engine.law), is_embedded = has_embedding(engine.law);
  const RowHalf fall = half_row(h * world.steady_gravity(), 0);
  RowBox box;
  double taken = 0;
  const auto finish = [&, damped = is_damped](Index b) {
    PairRow& row = rows[b];
    if (row.place[3] == 0)
      book_held(world, b, vector_of(row.place), h * vector_of(row.force), Vec3::Zero());
    RowHalf kick = (h * row.place[3]) * row.force;
    if (row.place[3] > 0) kick += fall;
    const RowHalf v = half_row(velocity[b], 0) + kick;
    velocity[b] = vector_of(v);
    drift(row, v, first);
    if (second != 0) drift(row, v, second);
    box.add(v);
    if (damped) {
      ahead[b] = vector_of(v + 0.5 * kick);
      heat[b] += h * row.force[3];
      taken += h * row.force[3];
    }
    row.force = RowHalf{};
  };
  push_from_walls(world, engine.law, engine.at_walls, h, rows);
  with_terms(world, engine, damping, [&](const auto& terms) {
    const auto* v = reinterpret_cast<const double*>(is_damped ? ahead : velocity);
    const auto sweep = [&]<bool damped, bool embedded>() {
      sweep_pairs<damped, embedded>(engine.near.windows, terms, engine.pushes.data(), v, rows,
                                    finish);
    };
    if (is_embedded)
      is_damped ? sweep.template operator()<true, true>()
                : sweep.template operator()<false, true>();
    else
      is_damped ? sweep.template operator()<true, false>()
                : sweep.template operator()<false, false>();
  });
  world.ledger.dissipated += taken;
  return box;
}

}  // namespace

/// J on this rank, with pairs and rows as they are.
SPALL_KERNEL(double, energy_of_pairs, (const World& world, Potential& engine), (world, engine)) {
  double energy = with_terms(world, engine, 0.0, [&](const auto& terms) {
    return sweep_energy(engine.near.windows, terms, engine.rows.data(), world.bodies.owned);
  });
  energy += energy_at_walls(world, engine.law, engine.at_walls, engine.rows.data());
  const Embeddings laws(engine.law);
  if (!laws.any()) return energy;
  measure_crowding(world, engine);
  for (Index b = 0; b < world.bodies.owned; ++b)
    if (const EmbeddingLaw* law = laws.of(world.bodies.material[b]))
      energy += law->volume(world.bodies.mass[b]) * law->energy(engine.crowding[b]);
  return energy;
}

namespace {

/// Whether anything gives bodies energy that may carry them through each other, through walls or
/// what is moved. Pairs alone have no more than when the step was checked; a uniform field lets all
/// bodies fall alike.
bool is_driven(const World& world) {
  const bool falls = world.walls().size() > 0 && !world.steady_gravity().isZero(0);
  return !world.motions.empty() || world.gravity.method != GravityMethod::none ||
         !world.own_forces.empty() || falls;
}

/// What `smooth_steps` asks of forces.
class Motion {
 public:
  Motion(World& world, Potential& engine)
      : world_(world),
        engine_(engine),
        damping_(damping_of(world, engine.law)),
        is_damped_(is_damped(engine.law)),
        embeddings_(engine.law),
        searches_(engine.near.searches),
        is_driven_(is_driven(world)) {}

  void begin(double h) {
    h_ = h;
    velocities_ = velocities_with_walls(world_);
    fill_rows(world_, engine_);
  }
  void drift(double t) {
    for (Index b = 0; b < world_.bodies.owned; ++b)
      spall::drift(engine_.rows[b], half_row(world_.bodies.velocity[b], 0), t);
    move(t);
  }
  double energy() {
    update_pairs(world_, engine_, is_damped_);
    return energy_of_pairs(world_, engine_);
  }
  void kick(double h, double first, double second) {
    if (!world_.own_forces.empty()) kick_by_program(h);
    prescribe_velocities();
    update_pairs(world_, engine_, is_damped_);
    if (embeddings_.any()) update_pushes(world_, engine_, embeddings_);
    if (std::exchange(searches_, engine_.near.searches) != engine_.near.searches && is_driven_)
      engine_.check_steps(world_, {h_, h_, "bodies have become faster"});
    velocities_ = kick_and_drift(world_, engine_, damping_, h, first, second);
    StageTimer timer(world_.stages, "motion");
    if (world_.walls().size() > 0) velocities_.add(Vec3(Vec3::Zero()));
    move(first + second);
  }
  void end() {
    StageTimer timer(world_.stages, "motion");
    take_rows(world_, engine_);
  }

 private:
  void kick_by_program(double h) {
    take_rows(world_, engine_);
    kick_by_own_forces(world_, h);
    if (is_damped_)
      for (Index b = 0; b < world_.bodies.owned; ++b)
        engine_.ahead[b] = world_.bodies.velocity[b] + world_.bodies.kick[b] / 2;
  }
  void prescribe_velocities() {
    const auto rows = set_prescribed_velocities(world_, world_.time - h_ / 2, h_);
    if (is_damped_)
      for (Index b : rows) engine_.ahead[b] = world_.bodies.velocity[b];
  }
  /// Others have moved by `t`: bodies of moving groups go where they must.
  void move(double t) {
    for (const auto& [row, position] : advance_prescribed(world_, t, velocities_)) {
      world_.bodies.position[row] = position;  // by which the next place knows its image
      engine_.rows[row].place = half_row(position, engine_.rows[row].place[3]);
    }
    book_motion(world_.comm, velocities_, t, engine_.near);
  }

  World& world_;
  Potential& engine_;
  ByPair<double> damping_;
  bool is_damped_;
  Embeddings embeddings_;
  std::int64_t searches_;  // after which the step was found short enough
  bool is_driven_;
  double h_ = 0;
  RowBox velocities_;
};

}  // namespace

SPALL_KERNEL(StepReport, potential_steps,
             (World & world, Potential& engine, const StepRequest& request),
             (world, engine, request)) {
  return smooth_steps(world, Motion(world, engine), engine.integrator, request);
}

double potential_energy(World& world, Potential& engine) {
  fill_rows(world, engine);
  update_pairs(world, engine, false);
  return world.comm.sum(energy_of_pairs(world, engine));
}

double closing_speed(const World& world, const ByPair<PairPotential>& laws, double lasts) {
  const Bodies& bodies = world.bodies;
  // Images and walls are met from anywhere, and what moves as prescribed may come to any place.
  if (world.period.any() || world.walls().size() > 0 || !world.motions.empty())
    return largest_meeting_speed(world, lasts);
  const auto owned = [&](const std::vector<Vec3>& field) {
    return std::span(field.data(), bodies.owned);
  };
  const MotionCells cells(world.comm, owned(bodies.position), motion_cell * reach_of(laws));
  return cells.closing_speed(world.comm, owned(bodies.position), owned(bodies.velocity));
}

// --- the engine ---

void Potential::check_steps(const World& world, const PlannedSteps& steps) const {
  const auto& [h, lasts, place] = steps;
  check_period(world.period, reach_of(law), place);
  const double speed = closing_speed(world, law, lasts);
  const Walls walls = world.walls();
  const std::vector<Masses> masses = masses_of(world, law);
  if (law.uniform()) {
    const Masses& all = masses[0];
    const double reduced = walls.size() > 0 ? all.heaviest : all.reduced();
    return check_step(law.common(), h, {all.lightest, reduced, speed}, place);
  }
  for (int a = 0; a < law.materials(); ++a)
    for (int b = 0; b <= a; ++b) {
      if (!masses[a].any() || !masses[b].any()) continue;
      const std::string pair = names_of_pair(world, b, a);
      require(law(a, b).given(), "{}: no law is given between {}", place, pair);
      check_step(law(a, b), h,
                 {std::min(masses[a].lightest, masses[b].lightest),
                  a == b ? masses[a].reduced() : masses[a].reduced(masses[b]), speed},
                 fmt::format("{}, {}", place, pair));
    }
  for (std::size_t w = 0; w < walls.size(); ++w)
    for (int a = 0; a < law.materials(); ++a) {
      if (!masses[a].any()) continue;
      const int b = walls.material(w) == same_material ? a : walls.material(w);
      check_step(law(a, b), h, {masses[a].lightest, masses[a].heaviest, speed},
                 fmt::format("{}, {} at a wall", place, names_of_pair(world, b, a)));
    }
}

StepReport Potential::advance(World& world, const StepRequest& request) {
  return potential_steps(world, *this, request);
}

namespace {

/// Pairs as bodies are now. They are found anew, in a copy with ghosts of its own, so that no body
/// changes its rank.
struct Found {
  World world;
  Potential engine;

  Found(const World& from, const Potential& of) : world(from), engine(of.law) {
    resize(world.bodies, world.bodies.owned);
    find_near_pairs(world.comm, world.bodies, world.period, {reach_of(engine.law)}, 0,
                    bonds_to_make(world, engine.law), bonds_of(from.bodies, of.near), engine.near);
    engine.at_walls = bodies_at_walls(world, engine.law, 0);
    fill_rows(world, engine);
  }
};

}  // namespace

double Potential::energy(const World& world) const {
  Found found(world, *this);
  return world.comm.sum(energy_of_pairs(found.world, found.engine));
}

PairMemory Potential::remember(const World& world) const {
  return {.contacts = {}, .bonds = bonds_of(world.bodies, near)};
}

void Potential::restart_pairs(World& world, PairMemory memory) {
  resize(world.bodies, world.bodies.owned);
  near = {};
  near.bonds = std::move(memory.bonds);
}

void Potential::measure_fields(World& world) const {
  measure_damage(world.bodies, near);
}

namespace {

template <class F>
void for_each_pair_of(const Found& found, F&& f) {
  const NearPairs& pairs = found.engine.near;
  const Bodies& bodies = found.world.bodies;
  for_each_pair(pairs.windows, [&](std::size_t w, std::size_t slot, std::size_t l, Index i,
                                   Index j) {
    const PairPotential& p = found.engine.law(bodies.material[i], bodies.material[j]);
    const bool bound = p.breaking_strain > 0 ? pairs.windows[w].bound[slot] >> l & 1 : p.attracts();
    f(i, j, Vec3(bodies.position[j] - bodies.position[i]), bound);
  });
}

}  // namespace

void for_each_near_pair(const World& world, const Potential& engine,
                        const std::function<void(Index, Index, const Vec3&, bool)>& f) {
  for_each_pair_of(Found(world, engine), f);
}

std::optional<FoundPairs> Potential::found_pairs(const World& world) const {
  if (near.skin == 0) return {};
  const Bodies& bodies = world.bodies;
  FoundPairs found{
      .search = &near, .reach = {}, .work = work_of(bodies, near), .pairs = links_of(near.windows)};
  for (Index b = 0; b < bodies.owned; ++b)
    found.reach.push_back((near.reach + near.skin) / 2 - bodies.radius[b]);
  return found;
}

/// Neighbours hold together where a bond has any force, at most up to half the way to the second
/// neighbours of a lattice.
LinkedBodies Potential::links(const World& world) const {
  LinkedBodies linked;
  Found found(world, *this);
  for_each_pair_of(found, [&](Index i, Index j, const Vec3& x, bool bound) {
    const PairPotential& p = law(found.world.bodies.material[i], found.world.bodies.material[j]);
    if (!bound || x.norm() >= std::min(p.cutoff, (1 + std::sqrt(2.0)) / 2 * p.distance)) return;
    linked.links.i.push_back(i);
    linked.links.j.push_back(j);
  });
  linked.bodies = std::move(found.world.bodies);
  linked.ghosts = std::move(found.engine.near.ghosts);
  return linked;
}

}  // namespace spall
