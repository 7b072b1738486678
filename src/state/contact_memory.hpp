// What contacts leave to the next search, to other ranks and to restarts, by name.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "spall/types.hpp"

namespace spall {

/// What contacts leave to the next step and to restarts, by name, since rows die: impulses, or the
/// springs of penalty contact.
struct ContactMemory {
  std::vector<BodyId> i;      ///< the lower id
  std::vector<BodyId> j;      ///< the other id, or -1 - plane
  std::vector<Vec3> impulse;  ///< N s, acts on j; penalty contact: m, sliding of j against i
  std::vector<Vec3> rolling;  ///< m, the same from either side; empty where nothing resists rolling
  /// Of bodies with shapes: which of their spheres touch, of i and of j. Empty where all are
  /// spheres.
  std::vector<std::array<std::int32_t, 2>> spheres;

  std::size_t size() const { return i.size(); }
  std::array<std::int32_t, 2> spheres_of(std::size_t m) const {
    return spheres.empty() ? std::array<std::int32_t, 2>{} : spheres[m];
  }
  Vec3 rolling_of(std::size_t m) const { return rolling.empty() ? Vec3(Vec3::Zero()) : rolling[m]; }

  void reserve(std::size_t count) {
    i.reserve(count);
    j.reserve(count);
    impulse.reserve(count);
  }
  void add(BodyId lower, BodyId other, const Vec3& first, const Vec3& second = Vec3::Zero()) {
    if (rolling.empty() && !second.isZero(0)) rolling.assign(size(), Vec3::Zero());
    i.push_back(lower);
    j.push_back(other);
    impulse.push_back(first);
    if (!rolling.empty() || !second.isZero(0)) rolling.push_back(second);
    if (!spheres.empty()) spheres.push_back({});
  }
  /// Of the entry that was added last.
  void name_spheres(const std::array<std::int32_t, 2>& touching) {
    spheres.resize(size());
    spheres.back() = touching;
  }
};

/// What contacts left, as one copy for all that hold it: the state that a run keeps, and the steps
/// that go on from it.
class SharedContacts {
 public:
  SharedContacts() = default;
  SharedContacts(ContactMemory memory)
      : held_(std::make_shared<const ContactMemory>(std::move(memory))) {}

  operator const ContactMemory&() const { return **this; }
  const ContactMemory* operator->() const { return &**this; }
  const ContactMemory& operator*() const {
    static const ContactMemory none;
    return held_ ? *held_ : none;
  }

 private:
  std::shared_ptr<const ContactMemory> held_;
};

}  // namespace spall
