// One line a key, with its unit, its range and its meaning.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <set>

#include "engine/between.hpp"
#include "potential/constitutive.hpp"
#include "potential/engine.hpp"
#include "potential/settings.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

using namespace dimension;  // energy, length ...: the units of the keys

constexpr Choice<PairLaw> pair_laws[] = {{"lennard_jones", PairLaw::lennard_jones},
                                         {"mie", PairLaw::mie},
                                         {"morse", PairLaw::morse},
                                         {"steinhauser", PairLaw::steinhauser},
                                         {"program", PairLaw::program}};
constexpr Choice<Match> matches[] = {{"solid", Match::solid}, {"bulk", Match::bulk}};

void read_exponent(Section& in, std::string_view key, std::string_view meaning, int& exponent) {
  std::int64_t value = exponent;
  in.take(key, meaning, value, 1);
  in.check(key, value <= 100, "is more than 100");
  exponent = static_cast<int>(value);
}

/// Bonds that break at a force or an energy, as strains.
void read_strength(Section& in, PairPotential& p) {
  double most = 0;
  const auto take = [&](std::string_view key, std::string_view meaning, Dimension dimension,
                        double (*strain_of)(const PairPotential&, double)) {
    if (!in.reads(p.breaking_strain == 0)) return;
    in.take(key, meaning, most, positive(dimension));
    if (!in.has(key)) return;
    p.breaking_strain = strain_of(p, most);
    in.check(key, p.breaking_strain > 0, "is more than the law bears");
  };
  take("breaking_force", "instead of breaking_strain: where the law pulls as much", force,
       strain_of_force);
  take("breaking_energy", "instead of breaking_strain: where the law has stored as much", energy,
       strain_of_energy);
}

/// A law follows whose bonds break at this strain, unless it is 0.
void set_breaking_strain(PairPotential& p, double strain) {
  if (strain == 0) return;
  p.breaking_strain = strain;
  p.cutoff = (1 + 2 * strain) * p.distance;
}

/// A law by hand, or what is changed of one that follows from materials.
void read_law(Section& in, PairPotential& p, bool hand) {
  const auto by_hand = [&](bool asked) { return in.reads(hand && asked); };
  if (by_hand(true)) {
    in.need("law", "program: of a program that uses Spall's library", p.law, pair_laws);
  }
  if (by_hand(p.law != PairLaw::program))
    in.need("depth", "energy that parts a pair", p.depth, positive(energy));
  if (by_hand(true))
    in.need("distance", "of the centres of a pair at rest", p.distance, positive(length));
  if (by_hand(p.law == PairLaw::mie)) {
    read_exponent(in, "repulsive", "m of mie", p.repulsive);
    read_exponent(in, "attractive", "n of mie", p.attractive);
    in.check("repulsive", p.repulsive > p.attractive, "is not more than attractive");
  }
  if (by_hand(p.law == PairLaw::morse)) {
    in.need("steepness", "a d of morse; (4 s - 2) for a Hugoniot slope s", p.steepness,
            positive(number));
    in.check("steepness", p.steepness <= 100, "is more than 100");
  }
  if (by_hand(p.law == PairLaw::steinhauser))
    in.need("tension", "stiffness of steinhauser beyond distance", p.tension,
            positive(spring_constant));
  if (in.reads(p.law != PairLaw::program)) {
    in.take("breaking_strain", "the force falls from this strain to none at twice of it",
            p.breaking_strain, Quantity{number, 0, 1});
    in.check("breaking_strain", hand || !in.has("breaking_strain") || p.breaking_strain > 0,
             "is 0, but bonds of laws that follow from materials break");
    if (by_hand(p.breaking_strain == 0)) read_strength(in, p);
  }
  if (by_hand(p.breaking_strain == 0)) {
    in.need("cutoff", "distance beyond which there is no force; follows from breaking_strain",
            p.cutoff, positive(length));
    in.check("cutoff", p.cutoff > p.distance && p.cutoff <= 6 * p.distance,
             "is not between distance and six times of it");
  }
  if (p.breaking_strain > 0) p.cutoff = (1 + 2 * p.breaking_strain) * p.distance;
  in.take("damping", "of approaching and parting while nearer than distance; 1: critical",
          p.damping, not_negative(number));
}

void read_between(Section& in, double damping, LawBetween& between) {
  in.need("materials", "two, or one twice", between.materials);
  in.check("materials", between.materials.size() == 2, "does not name two materials");
  between.place = in.place("materials");
  between.by_hand = in.has("law");
  between.law.damping = damping;
  const std::vector<std::string>& names = between.materials;
  between.bonded = between.by_hand || (names.size() == 2 && names[0] == names[1]);
  in.take("bonded",
          "true: the pair pulls, and bonds that break are made between groups too; false: it does "
          "not; left out: true in one material and by hand, but between groups no bonds are made",
          between.bonded);
  between.law.bonds_groups = in.has("bonded") && between.bonded;
  read_law(in, between.law, between.by_hand);
  in.check("breaking_strain", between.bonded || between.law.breaking_strain == 0,
           "needs bonded = true: a pair that does not pull has nothing to break");
}

void read_pair_potential(Section& in, PotentialSettings& settings) {
  std::string material;
  DerivedLaw derived;
  in.take("material", "the law of its bodies is morse's and follows from its constants", material);
  in.take("materials",
          "the same of several; between two bodies of different ones, the two halves of a bond in "
          "series, which does not pull",
          derived.materials);
  if (in.has("material")) derived.materials.push_back(material);
  derived.place = in.place(in.has("materials") ? "materials" : "material");
  if (!derived.materials.empty()) settings.derived = derived;
  if (in.reads(settings.derived.has_value()))
    in.take(
        "match",
        "solid: moduli, shocks and pressure of heat; bulk: pairs alone, bulk modulus and its slope",
        (settings.derived ? *settings.derived : derived).match, matches);
  read_law(in, settings.common, !settings.derived);
  in.tables("between", "[[pair_potential.between]]: of one pair of materials, instead",
            [&](Section& s) {
              read_between(s, settings.common.damping, settings.between.emplace_back());
            });
}

void read(Section& in, EngineSettings& settings) {
  PotentialSettings potential;
  if (in.table("pair_potential",
               "between bodies, in phases with method = \"potential\"; by hand it is all pairs'",
               [&](Section& s) { read_pair_potential(s, potential); }))
    settings.set(potential);
}

/// The law between two bodies of a solid.
PairPotential law_of_solid(const Surroundings& around, std::span<const MaterialUse> uses,
                           const DerivedLaw& from, int material, const PairPotential& asked) {
  const std::string& name = around.materials[material].name;
  const std::optional<Solid>& solid = around.materials[material].solid;
  require(solid.has_value(),
          "{} = \"{}\" is not a solid of [materials]: one with a library, a file or a table "
          "[materials.{}.solid]",
          from.place, name, name);
  PairPotential p = morse_law(*solid, shared_lattice(around, uses, material, from.place),
                              from.match, fmt::format("{} = \"{}\"", from.place, name));
  p.damping = asked.damping;
  set_breaking_strain(p, asked.breaking_strain);
  return p;
}

/// Laws by pair of materials; the last place stands for one that no law names.
ByPair<PairPotential> laws_by_pair(const Surroundings& around, std::span<const MaterialUse> uses,
                                   const PotentialSettings& settings) {
  ByPair<PairPotential> laws(static_cast<int>(around.materials.size()) + 1,
                             settings.derived ? PairPotential{} : settings.common);
  std::vector<int> solids;
  if (settings.derived)
    for (const std::string& name : settings.derived->materials) {
      const int a = find_material(around.materials, name, settings.derived->place);
      laws.set(a, a, law_of_solid(around, uses, *settings.derived, a, settings.common));
      for (int b : solids)
        if (b != a) laws.set(a, b, mixed_law(laws(a, a), laws(b, b), false));
      solids.push_back(a);
    }
  const ByPair<PairPotential> of_solids = laws;
  ByPair<const LawBetween*> told(laws.materials(), nullptr);
  for (const LawBetween& between : settings.between) {
    const int a = find_material(around.materials, between.materials[0], between.place);
    const int b = find_material(around.materials, between.materials[1], between.place);
    require(!told(a, b), "{} = {} and {}: told of before, at {}", between.place,
            between.materials[0], between.materials[1], told(a, b) ? told(a, b)->place : "");
    told.set(a, b, &between);
    PairPotential p = between.law;
    if (!between.by_hand) {
      const auto derived = [&](int m) { return std::ranges::find(solids, m) != solids.end(); };
      require(derived(a) && derived(b),
              "{}: without a law by hand both must be of pair_potential.materials, from which "
              "it follows",
              between.place);
      p = a == b ? of_solids(a, a) : mixed_law(of_solids(a, a), of_solids(b, b), between.bonded);
      p.damping = between.law.damping;
      set_breaking_strain(p, between.law.breaking_strain);
    }
    if (!between.bonded) {
      p.breaking_strain = 0;
      p.cutoff = p.distance;
    }
    p.bonds_groups = between.law.bonds_groups;
    laws.set(a, b, p);
  }
  return laws;
}

void derive(const Surroundings& around, std::span<const MaterialUse> uses,
            EngineSettings& settings) {
  auto* potential = settings.find<PotentialSettings>();
  if (!potential) return;
  potential->law = laws_by_pair(around, uses, *potential);
  // Where all bodies have the same law, materials need not be looked at.
  std::set<int> used;
  for (const MaterialUse& use : uses) used.insert(use.material);
  const Walls walls = around.walls();
  for (std::size_t w = 0; w < walls.size(); ++w)
    if (walls.material(w) != same_material) used.insert(walls.material(w));
  for (const LawBetween& between : potential->between)  // an impactor's is of no group
    for (const std::string& name : between.materials)
      used.insert(find_material(around.materials, name, between.place));
  if (!potential->derived) used.insert(static_cast<int>(around.materials.size()));
  if (used.empty()) return;
  const PairPotential one = potential->law(*used.begin(), *used.begin());
  bool same = true;
  for (int a : used)
    for (int b : used) same &= potential->law(a, b) == one;
  if (same) potential->law = one;
}

/// Calls `f(a, b, use)` for each pair of materials that groups are of; `use` is of b.
template <class F>
void for_each_pair_in_use(std::span<const MaterialUse> uses, F&& f) {
  std::set<std::pair<int, int>> seen;
  for (const MaterialUse& b : uses)
    for (const MaterialUse& a : uses.first(&b - uses.data() + 1))
      if (seen.insert(std::minmax({a.material, b.material})).second) f(a.material, b.material, b);
}

void check(const Surroundings& around, std::span<const MaterialUse> uses,
           const EngineSettings& settings, const PhaseView& phase) {
  const auto* potential = settings.find<PotentialSettings>();
  require(potential, "{}.method = \"potential\" needs [pair_potential]: the law between two bodies",
          phase.place);
  check_images(around, phase.place);
  const Walls walls = around.walls();
  for (const MaterialUse& use : uses) {
    if (walls.size() == 0) break;
    const bool embedded = potential->law(use.material, use.material).embedding.bulk_modulus > 0;
    require(!embedded,
            "{}.method = \"potential\": walls act by pairs alone, and the law of {} has a pressure "
            "beside them: pair_potential.match = \"bulk\" has none",
            phase.place, around.materials[use.material].name);
    for (std::size_t w = 0; w < walls.size(); ++w)
      if (const int of_wall = walls.material(w); of_wall != same_material)
        require(potential->law(use.material, of_wall).given(),
                "{}.method = \"potential\" has no law between bodies and walls of {}; name them in "
                "pair_potential.materials or in a [[pair_potential.between]]",
                phase.place, names_of_pair(around, use.material, of_wall));
  }
  require(!phase.cohesion,
          "{}.cohesion is that of contacts: in method = \"potential\" pairs attract by their law",
          phase.place);
  require(!phase.impactor || !potential->derived,
          "{}.method = \"potential\": the impactor has no law, since it is of none of {}; make it "
          "a group, or give the law by hand",
          phase.place, potential->derived ? potential->derived->place : "");
  // Bodies are as large as their laws say, whatever they are drawn as.
  for (const MaterialUse& use : uses)
    require(
        !use.unequal,
        "{}: {}.method = \"potential\" knows no radii, and its bodies have different ones: they "
        "would act as if all were alike",
        use.place, phase.place);
  constexpr double far_off = 1.5;
  for (const MaterialUse& one : uses)
    for (const MaterialUse& other : uses.first(&one - uses.data() + 1)) {
      const PairPotential law = potential->law(one.material, other.material);
      if ((&one == &other && one.lone) || !law.given()) continue;
      const double touch = (one.diameter + other.diameter) / 2;
      require(
          one.diameter == 0 || other.diameter == 0 ||
              (touch < far_off * law.distance && law.distance < far_off * touch),
          "{}: {}.method = \"potential\" knows no radii: its bodies and those of {} touch {:g} m "
          "apart, and rest {:.4g} m apart by their law; make a large body of many small ones, or "
          "give it a material and a law of its own",
          one.place, phase.place, other.group, touch, law.distance);
    }
  for_each_pair_in_use(uses, [&](int a, int b, const MaterialUse& use) {
    require(potential->law(a, b).given(),
            "{}.material = \"{}\": {}.method = \"potential\" has no law between bodies of {}; "
            "name {} in pair_potential.materials or in a [[pair_potential.between]]",
            use.place, around.materials[use.material].name, phase.place,
            names_of_pair(around, a, b), a == b ? "it" : "them");
  });
}

FieldSet fields(const Surroundings&, const EngineSettings& settings) {
  const ByPair<PairPotential> laws = settings.get<PotentialSettings>().law;
  FieldSet fields;
  if (laws.any([](const PairPotential& p) { return p.damping > 0; }))
    fields |= {Field::heat, Field::kick};
  if (laws.any([](const PairPotential& p) { return p.breaking_strain > 0; }))
    fields |= {Field::bonds, Field::damage};
  return fields;
}

bool breaks(const EngineSettings& settings, int material) {
  return settings.get<PotentialSettings>().law(material, material).breaking_strain > 0;
}

const char* name_of(PairLaw law) {
  switch (law) {
    case PairLaw::lennard_jones:
      return "Lennard-Jones";
    case PairLaw::mie:
      return "Mie";
    case PairLaw::morse:
      return "Morse";
    case PairLaw::program:
      return "of the program";
    case PairLaw::steinhauser:
      return "Steinhauser";
  }
  return "";
}

/// A pair potential, what it makes of a lattice of bodies of `mass` (kg), and the longest step.
std::string describe_law(const PairPotential& p, const std::string& title, const Lattice* lattice,
                         double mass) {
  std::string text = fmt::format(
      "\n  pair potential: {}, stiffness {:.4g} N/m, depth {:.4g} J, distance {:.4g} m{}\n",
      name_of(p.law), stiffness(p), p.depth, p.distance, title);
  if (p.law == PairLaw::morse) text += fmt::format("    steepness a d = {:.4g}\n", p.steepness);
  if (p.embedding.bulk_modulus > 0)
    text += fmt::format(
        "    embedded: bulk modulus {:.4g} Pa, Hugoniot slope {:.4g}, Gruneisen's parameter "
        "{:.4g}\n",
        p.embedding.bulk_modulus, p.embedding.hugoniot_slope, p.embedding.gruneisen);
  if (!p.attracts()) text += "    repels only: no force beyond its distance\n";
  if (p.breaking_strain > 0)
    text += fmt::format("    bonds break at {:.3g} % of strain{}\n", 100 * p.breaking_strain,
                        p.bonds_groups ? "; of different groups too" : "");
  if (p.damping > 0)
    text += fmt::format("    damped at {:g} of critical where nearer than that\n", p.damping);
  if (lattice && p.attracts() && lattice->distance >= p.cutoff)
    text += fmt::format(
        "    its lattice has a spacing of {:g} m, and the law ends at {:g} m: no body is in reach "
        "of another\n",
        lattice->distance, p.cutoff);
  // Constants are those of the lattice at rest: of another spacing they would be others.
  constexpr double same_spacing = 0.1;
  if (lattice && std::isfinite(mass) &&
      std::abs(lattice->distance / p.distance - 1) <= same_spacing) {
    const LatticeSpeeds c = sound_speeds(p, mass);
    text += fmt::format(
        "    its lattice: bulk sound speed {:.4g} m/s; waves along [100] {:.4g}, [110] {:.4g}, "
        "[111] {:.4g} m/s;\n    tears at {:.3g} Pa in a plane wave\n",
        c.bulk, c.along_100, c.along_110, c.along_111, plane_strength(p, *lattice));
  }
  return text + fmt::format("    steps of at most {:.3g} s\n", longest_step(p, mass));
}

std::string describe(const Surroundings& around, std::span<const MaterialUse> uses,
                     const EngineSettings& settings) {
  const auto potential = settings.get<PotentialSettings>();
  // Of bodies of material m, or of any.
  const auto lightest = [&](int m) {
    double mass = infinity;
    for (const MaterialUse& use : uses)
      if (!use.fixed && (m < 0 || use.material == m)) mass = std::min(mass, use.mass);
    return mass;
  };
  const auto lattice = [&](int m) -> const Lattice* {
    const auto found = std::ranges::find_if(uses, [&](const MaterialUse& use) {
      return !use.fixed && use.lattice.neighbours == 12 && (m < 0 || use.material == m);
    });
    return found == uses.end() ? nullptr : &found->lattice;
  };
  if (potential.law.uniform())
    return describe_law(potential.law.common(),
                        potential.derived ? ", from " + potential.derived->materials.front() : "",
                        lattice(-1), lightest(-1));
  std::string text;
  for_each_pair_in_use(uses, [&](int a, int b, const MaterialUse&) {
    text += describe_law(potential.law(a, b), ", between bodies of " + names_of_pair(around, a, b),
                         a == b ? lattice(a) : nullptr, std::min(lightest(a), lightest(b)));
  });
  return text;
}

std::unique_ptr<Engine> make(const EngineSettings& settings) {
  return std::make_unique<Potential>(settings.get<PotentialSettings>().law);
}

}  // namespace

std::string names_of_pair(const Surroundings& around, int a, int b) {
  const auto name = [&](int m) {
    return m < std::ssize(around.materials) ? around.materials[m].name : std::to_string(m);
  };
  return a == b ? name(a) : fmt::format("{} and {}", name(a), name(b));
}

const EngineType potential_engine{
    .name = "potential",
    .help = "bodies that act on many neighbours by pair potentials; solids and fluids",
    .moves_groups = true,
    .tables = {"pair_potential"},
    .read = read,
    .derive = derive,
    .check = check,
    .fields = fields,
    .breaks = breaks,
    .describe = describe,
    .make = make};

}  // namespace spall
