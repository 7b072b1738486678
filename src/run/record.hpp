// What a run keeps of its steps: a row of the series, and sums for the results.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "engine/engine.hpp"
#include "output/restart.hpp"
#include "output/results.hpp"
#include "output/series.hpp"
#include "run/account.hpp"
#include "spall/comm.hpp"

namespace spall {

/// Every stage that a run times, in the order of a step.
extern const std::vector<std::string> stages;

class Record {
 public:
  /// Called after every step, or several at once that solve for nothing.
  void book(const StepReport& report, bool solved);
  double relaxed() const { return relaxed_; }  ///< steps
  /// Overlaps of steps are this rank's: brings them together. Collective.
  void meet(const Comm& comm) {
    overlap_ = comm.max(overlap_);
    soft_overlap_ = comm.max(soft_overlap_);
  }
  void save(Scalars& scalars) const;
  /// What a file of an earlier version has not is left out.
  void load(const Scalars& scalars);

  static std::vector<Column> columns();  ///< beside step and time
  /// The row of the instant at which the step began; `contacts` are those of all ranks.
  static std::vector<double> row(std::int64_t phase, std::int64_t contacts, const Balance& balance,
                                 const StepReport& report, double overlap, const StageUses& uses);

  /// Adds [solver]; without solved contacts it holds the number of steps alone.
  void add_to(ResultTable& table, std::int64_t steps, bool solves) const;
  /// What a reader must know of hits that did not bounce, beside what was `dissipated` (J); or
  /// nothing.
  std::string warning(double dissipated) const;

  /// What a restart file keeps.
  template <class Self, class F>
  static void for_each_scalar(Self& self, F&& f) {
    f("record.solved", self.solved_);
    f("record.products", self.products_);
    f("record.correction_products", self.correction_products_);
    f("record.residual_max", self.residual_max_);
    f("record.residual_squares", self.squares_);
    f("record.residual_relative", self.worst_relative_);
    f("record.unconverged", self.unconverged_);
    f("record.over_tolerance", self.over_tolerance_);
    f("record.relaxed", self.relaxed_);
  }

 private:
  double solved_ = 0;  // steps
  double products_ = 0, correction_products_ = 0, residual_max_ = 0, squares_ = 0;
  double worst_relative_ = 0, unconverged_ = 0, over_tolerance_ = 0, relaxed_ = 0;
  double withheld_ = 0;                    // J
  double overlap_ = 0, soft_overlap_ = 0;  // largest over the smaller radius, rigid or by springs
};

}  // namespace spall
