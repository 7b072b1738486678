// A law between two bodies that a program brings: a type, handed to the sweep over all pairs.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>

#include "spall/lanes.hpp"

namespace spall {

/// What the sweep asks of such a law, for eight pairs at a time that are r^2 (m^2) apart. Vectors
/// go by reference: a program and Spall may be compiled for other instructions.
class PairLawOfProgram {
 public:
  virtual ~PairLawOfProgram() = default;
  virtual void force_over_distance(const Lanes& r2, Lanes& result) const = 0;
  virtual void energy(const Lanes& r2, Lanes& result) const = 0;
};

/// Of a type with two functions of r^2, written with + - * / and what spall/lanes.hpp has:
///
///   Lanes force_over_distance(const Lanes& r2) const;   N/m, of the repulsion: -U'(r)/r
///   Lanes energy(const Lanes& r2) const;                J, U(r)
template <class Law>
class PairLawOf final : public PairLawOfProgram {
 public:
  explicit PairLawOf(Law law) : law_(std::move(law)) {}
  void force_over_distance(const Lanes& r2, Lanes& result) const override {
    result = law_.force_over_distance(r2);
  }
  void energy(const Lanes& r2, Lanes& result) const override { result = law_.energy(r2); }

 private:
  Law law_;
};

}  // namespace spall
