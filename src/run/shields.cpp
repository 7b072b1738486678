// Verdicts in numbers and in words.
// SPDX-License-Identifier: BSD-3-Clause
#include "run/shields.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scene/shape.hpp"

namespace spall {

Shields::Shields(const Comm& comm, const Case& scene) {
  for (const Shield& shield : scene.shields)
    walls_.push_back({.wall = lay_wall(comm, scene, shield),
                      .last = {},
                      .most_spall = {},
                      .largest = {},
                      .times = {},
                      .margins = {}});
}

std::string Shields::describe() const {
  std::string text;
  for (const Judged& judged : walls_) {
    const ShieldWall& wall = judged.wall;
    text += fmt::format(
        "\n  judged in the end: {}, {:.3g} spacings thick, its rear towards {}; openings "
        "narrower than {:.3g} m are not seen\n",
        wall.name, wall.thickness / wall.spacing, words_of_direction(wall.start.normal),
        wall.spacing);
  }
  return text;
}

namespace {

/// What the margin is, which depends on the verdict.
const char* meaning_of_margin(Outcome outcome) {
  switch (outcome) {
    case Outcome::held:
      return "of the thickness: the thinnest part";
    case Outcome::detached_spall:
      return "of the thickness: minus the diameter of a ball of the spall";
    case Outcome::perforated:
      return "of the thickness: minus the diameter of the largest opening";
  }
  return "";
}

void add(const ShieldWall& wall, const WallVerdict& v, const Coming& largest, ResultTable& table) {
  const std::string& section = wall.section;
  table.add(section, "wall", wall.name);
  table.add(section, "verdict", std::string(name_of(v.outcome)), "",
            "held, detached spall or perforated");
  table.add(section, "margin", v.margin, "", meaning_of_margin(v.outcome));
  table.add(section, "thickness", wall.thickness, "m", "of the wall at the start");
  table.add(section, "thinnest", v.thinnest, "m", "part of its main piece");
  table.add(section, "hole", v.hole, "m", "diameter of a circle as large as the largest opening");
  table.add(section, "openings", v.openings);
  table.add(section, "opening_at_edge", v.opening_at_edge, "", "the wall may be too small");
  table.add(section, "spall_mass", v.spall_mass, "kg",
            "behind its rear, moving away; of what something has stopped there, the most that was");
  table.add(section, "spall_pieces", v.spall_pieces, "", "single bodies, too");
  table.add(section, "spall_largest", v.spall_largest, "kg");
  table.add(section, "rim_mass", v.rim_mass, "kg", "the same, from the rim, which is not judged");
  table.add(section, "least_spall", v.least_spall, "kg", "from which on it counts");
  table.add(section, "spall_speed", v.spall_speed, "m/s", "against the wall, mean by mass");
  table.add(section, "still_coming", v.still_coming, "",
            "of the energy that flew at it: has not met it yet");
  const bool seen = largest.meets > 0;  // else pieces were not looked at in time
  table.add(section, "largest_met", seen ? largest.meets : std::nan(""), "J",
            "along the normal, of the piece with most of those that flew at what is judged");
  table.add(section, "largest_met_diameter", largest.diameter > 0 ? largest.diameter : std::nan(""),
            "m", "of a ball as heavy as it");
  const auto of_piece = [&](const Vec3& value) {
    return largest.diameter > 0 ? std::vector<double>{value.x(), value.y(), value.z()}
                                : std::vector<double>(3, std::nan(""));
  };
  table.add(section, "largest_met_size", of_piece(largest.size), "m",
            "full widths of an ellipsoid as heavy as it and of its form");
  table.add(section, "largest_met_rotation", of_piece(largest.rotation), "rad",
            "rotation vector that turns it from the axes");
  table.add(section, "largest_met_velocity", of_piece(largest.velocity), "m/s", "against the wall");
  table.add(section, "coarse", v.outcome == Outcome::held && is_coarse(wall, largest), "",
            "it held, and fewer than seven of its bodies lie across that: smaller ones may fail");
  table.add(section, "largest_passed", seen ? largest.passes : std::nan(""), "J",
            "the same, of those that flew past it; nan: none was seen to fly at it before the wall "
            "alone");
  table.add(section, "spacing", wall.spacing, "m", "of its bodies: narrower openings are not seen");
}

}  // namespace

bool is_still_failing(const WallVerdict& last, const std::vector<double>& margins) {
  constexpr double little = 0.05;  // of the margin
  return last.outcome == Outcome::held && margins.size() > 1 &&
         margins.rbegin()[1] - margins.back() > little * margins.back();
}

std::string sentence_of(const ShieldWall& wall, const WallVerdict& v, const Coming& largest) {
  // A group that is called "wall", as most are, is not named twice.
  const char* what = wall.name.find("wall") == std::string::npos ? "wall " : "";
  std::string text =
      fmt::format("{}{}: {}, margin {:.3g}: ", what, wall.name, name_of(v.outcome), v.margin);
  switch (v.outcome) {
    case Outcome::held:
      text += fmt::format("{:.3g} m of its {:.3g} m are left where it is thinnest", v.thinnest,
                          wall.thickness);
      break;
    case Outcome::detached_spall:
      text += fmt::format("{:.3g} kg in {} pieces leave its rear at {:.3g} m/s", v.spall_mass,
                          v.spall_pieces, v.spall_speed);
      break;
    case Outcome::perforated:
      text += fmt::format("{} opening{} of up to {:.3g} m{}", v.openings, v.openings > 1 ? "s" : "",
                          v.hole, v.opening_at_edge ? ", as far as its edge" : "");
      break;
  }
  if (v.rim_mass >= v.least_spall && v.outcome == Outcome::held)
    text += fmt::format("; its rim, which is not judged, has lost {:.3g} kg", v.rim_mass);
  // Where nothing was seen to meet it, nothing was looked at in time.
  if (largest.meets > 0 && largest.passes > largest.meets && v.outcome == Outcome::held)
    text += fmt::format(
        "; too narrow: a piece of {:.3g} J flew past what is judged, at which no piece of more "
        "than {:.3g} J flew",
        largest.passes, largest.meets);
  if (is_coarse(wall, largest) && v.outcome == Outcome::held)
    text += fmt::format(
        "; coarse: its bodies are {:.3g} m, and the largest piece that met it is a ball of {:.3g} "
        "m, so smaller ones may tell otherwise",
        wall.distance, largest.diameter);
  constexpr double little = 0.01;
  if (v.still_coming > little && v.outcome != Outcome::perforated)
    text += fmt::format("; not final: {:.2g} % of the energy that flies at it has not met it",
                        100 * v.still_coming);
  return text;
}

void Shields::watch(const World& world, const Engine& engine) {
  if (walls_.empty()) return;
  const LinkedBodies linked = engine.links(world);
  for (Judged& judged : walls_)
    judged.largest.add(look_at_what_comes(world.comm, linked, judged.wall));
}

std::vector<std::string> Shields::read_out(const World& world, const Engine& engine, double time) {
  std::vector<std::string> lines;
  if (walls_.empty()) return lines;
  const LinkedBodies linked = engine.links(world);
  for (Judged& judged : walls_) {
    judged.last = judge_wall(world.comm, linked, judged.wall);
    keep_spall(judged.most_spall, judged.last);
    judged.times.push_back(time);
    judged.margins.push_back(judged.last.margin);
    lines.push_back(sentence_of(judged.wall, judged.last, judged.largest));
  }
  return lines;
}

std::vector<std::string> Shields::conclude(const World& world, const Engine& engine, double time,
                                           ResultTable& table) {
  for (Judged& judged : walls_)  // of the last snapshot, which is of the same instant
    if (!judged.times.empty() && judged.times.back() >= time) {
      judged.times.pop_back();
      judged.margins.pop_back();
    }
  std::vector<std::string> lines = read_out(world, engine, time);
  for (std::size_t w = 0; w < walls_.size(); ++w) {
    const Judged& judged = walls_[w];
    add(judged.wall, judged.last, judged.largest, table);
    const bool fails = is_still_failing(judged.last, judged.margins);
    table.add(judged.wall.section, "still_failing", fails, "",
              "it held, and its margin fell by more than a twentieth since the time before");
    if (fails)
      lines[w] += fmt::format(
          "; still failing: its margin was {:.3g} at the time before, so a longer run may tell "
          "otherwise",
          judged.margins.rbegin()[1]);
    table.add(judged.wall.section, "times", judged.times, "s", "at which it was judged");
    table.add(judged.wall.section, "margins", judged.margins, "", "at these times");
  }
  return lines;
}

namespace {

std::string entry(const ShieldWall& wall, std::size_t row, const char* what) {
  return fmt::format("{}.{}.{}", wall.section, row, what);
}

/// Calls `f(key, value)` for what tells the most spall that was seen to leave it.
template <class SomeVerdict, class F>
void for_each_of_spall(const ShieldWall& wall, SomeVerdict& most, F&& f) {
  const auto key = [&](const char* name) { return wall.section + ".most_spall." + name; };
  f(key("margin"), most.margin);
  f(key("pieces"), most.spall_pieces);
  f(key("mass"), most.spall_mass);
  f(key("largest"), most.spall_largest);
  f(key("speed"), most.spall_speed);
}

/// Calls `f(key, value)` for what tells the form and the motion of the largest piece.
template <class SomeComing, class F>
void for_each_of_form(const ShieldWall& wall, SomeComing& largest, F&& f) {
  const auto each = [&](const char* name, auto& vector) {
    for (int k = 0; k < 3; ++k)
      f(fmt::format("{}.largest_met_{}.{}", wall.section, name, k), vector[k]);
  };
  each("size", largest.size);
  each("rotation", largest.rotation);
  each("velocity", largest.velocity);
}

}  // namespace

void Shields::save(Scalars& scalars) const {
  for (const Judged& judged : walls_) {
    scalars[judged.wall.section + ".largest_met"] = judged.largest.meets;
    scalars[judged.wall.section + ".largest_passed"] = judged.largest.passes;
    scalars[judged.wall.section + ".largest_met_diameter"] = judged.largest.diameter;
    scalars[judged.wall.section + ".largest_met_density"] = judged.largest.density;
    for_each_of_form(judged.wall, judged.largest,
                     [&](const std::string& key, double value) { scalars[key] = value; });
    if (judged.most_spall.outcome == Outcome::detached_spall)
      for_each_of_spall(judged.wall, judged.most_spall, [&](const std::string& key, auto value) {
        scalars[key] = static_cast<double>(value);
      });
    for (std::size_t r = 0; r < judged.times.size(); ++r) {
      scalars[entry(judged.wall, r, "time")] = judged.times[r];
      scalars[entry(judged.wall, r, "margin")] = judged.margins[r];
    }
  }
}

/// A wall that is named from here on has none.
void Shields::load(const Scalars& scalars) {
  for (Judged& judged : walls_) {
    const std::string& section = judged.wall.section;
    if (scalars.contains(section + ".largest_met")) {
      judged.largest.meets = find_scalar(scalars, section + ".largest_met");
      judged.largest.passes = find_scalar(scalars, section + ".largest_passed");
    }
    // Files before 2026-11-30 have none: then the wall is not told to be coarse.
    if (scalars.contains(section + ".largest_met_diameter")) {
      judged.largest.diameter = find_scalar(scalars, section + ".largest_met_diameter");
      judged.largest.density = find_scalar(scalars, section + ".largest_met_density");
      for_each_of_form(judged.wall, judged.largest, [&](const std::string& key, double& value) {
        if (scalars.contains(key)) value = find_scalar(scalars, key);
      });
    }
    if (scalars.contains(section + ".most_spall.mass")) {
      judged.most_spall.outcome = Outcome::detached_spall;
      for_each_of_spall(judged.wall, judged.most_spall,
                        [&]<class T>(const std::string& key, T& value) {
                          value = static_cast<T>(find_scalar(scalars, key));
                        });
    }
    for (std::size_t r = 0; scalars.contains(entry(judged.wall, r, "time")); ++r) {
      judged.times.push_back(find_scalar(scalars, entry(judged.wall, r, "time")));
      judged.margins.push_back(find_scalar(scalars, entry(judged.wall, r, "margin")));
    }
  }
}

}  // namespace spall
