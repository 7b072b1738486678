// Laws by pair of materials: a default for all pairs, and exceptions for named ones.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>
#include <vector>

namespace spall {

/// One law for each unordered pair of materials. A world without exceptions holds a single law.
template <class Law>
class ByPair {
 public:
  ByPair() : ByPair(Law{}) {}
  /// The same law for all pairs.
  ByPair(Law common) : common_(std::move(common)) {}  // NOLINT: a law is a table of one
  /// The same law for all pairs of so many materials, before exceptions are set.
  ByPair(int materials, Law common)
      : common_(common), materials_(materials), laws_(materials * materials, common) {}

  /// The law of bodies of materials `a` and `b`.
  const Law& operator()(int a, int b) const {
    return laws_.empty() ? common_ : laws_[a * materials_ + b];
  }
  void set(int a, int b, const Law& law) {
    laws_[a * materials_ + b] = laws_[b * materials_ + a] = law;
  }
  /// Whether one law serves all pairs.
  bool uniform() const { return laws_.empty(); }
  int materials() const { return materials_; }
  /// What pairs without an exception have; what events of phases change.
  const Law& common() const { return common_; }

  /// Calls `f(a, b, law)` for each pair of materials, a <= b; never where one law serves all.
  template <class F>
  void for_each_pair(F&& f) const {
    for (int a = 0; a < materials_; ++a)
      for (int b = a; b < materials_; ++b) f(a, b, (*this)(a, b));
  }
  /// Calls `f(law)` for the law of every pair, and for the default. May change them.
  template <class F>
  void for_each(F&& f) {
    f(common_);
    for (Law& law : laws_) f(law);
  }
  template <class F>
  void for_each(F&& f) const {
    f(common_);
    for (const Law& law : laws_) f(law);
  }

  /// Whether `f(law)` holds of one of them.
  template <class F>
  bool any(F&& f) const {
    bool found = false;
    for_each([&](const Law& law) { found = found || f(law); });
    return found;
  }

 private:
  Law common_;
  int materials_ = 0;
  std::vector<Law> laws_;  // materials x materials, symmetric; empty: all are `common_`
};

}  // namespace spall
