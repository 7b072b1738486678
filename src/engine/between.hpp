// The tables [[...between]] of a case: where the law of two materials differs from the default.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "keys/section.hpp"
#include "spall/error.hpp"
#include "state/by_pair.hpp"
#include "state/material.hpp"

namespace spall {

/// The place of the material of this name. Throws Error, which begins with `place`, without one.
int find_material(const std::vector<Material>& materials, const std::string& name,
                  const std::string& place);

/// Two materials as a case names them, before all materials are known.
struct NamedPair {
  std::array<std::string, 2> names;
  std::string place;  ///< "x.toml:9:13: contact.between.0.materials"

  /// Their places in `materials`. Throws Error where one is not there.
  std::array<int, 2> find(const std::vector<Material>& materials) const;
};

/// What differs between two materials; what is left out is the default's.
template <class Law>
struct Between {
  NamedPair pair;
  std::vector<std::pair<double Law::*, double>> changes;

  void take(Section& in, std::string_view key, double Law::*member, const Quantity& quantity) {
    std::optional<double> value;
    in.take(key, "left out: the default's", value, quantity);
    if (value) changes.emplace_back(member, *value);
  }
  bool changes_any(double Law::*member) const {
    for (const auto& [changed, value] : changes)
      if (changed == member) return true;
    return false;
  }
};

/// Reads the tables `between`; `read(section, between)` takes the keys that may differ.
template <class Law, class Read>
std::vector<Between<Law>> read_between(Section& in, Read&& read) {
  std::vector<Between<Law>> all;
  in.tables("between", "for two materials, where it differs", [&](Section& s) {
    Between<Law>& one = all.emplace_back();
    s.need("materials", "two names of [materials], which may be equal; \"impactor\", too",
           one.pair.names);
    one.pair.place = s.place("materials");
    read(s, one);
  });
  return all;
}

/// The laws of all pairs of materials; `complete(law, between)` sees each that differs. Throws
/// Error on materials that are not there and on pairs told twice.
template <class Law, class Complete>
ByPair<Law> laws_between(const Law& common, const std::vector<Material>& materials,
                         const std::vector<Between<Law>>& all, Complete&& complete) {
  if (all.empty()) return common;
  ByPair<Law> laws(static_cast<int>(materials.size()), common);
  ByPair<const Between<Law>*> told(static_cast<int>(materials.size()), nullptr);
  for (const Between<Law>& one : all) {
    const auto [a, b] = one.pair.find(materials);
    require(!told(a, b), "{} = {} and {}: told of before, at {}", one.pair.place, one.pair.names[0],
            one.pair.names[1], told(a, b) ? told(a, b)->pair.place : "");
    told.set(a, b, &one);
    Law law = common;
    for (const auto& [member, value] : one.changes) law.*member = value;
    complete(law, one);
    laws.set(a, b, law);
  }
  return laws;
}

}  // namespace spall
