// Contact problems that others wrote: FCLIB's local frictional-contact files.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "solver/problem.hpp"

namespace spall {

/// u = W r + q, r in the cone of mu (Acary, Bremond, Koziara & Perignon, FCLIB: a collection of
/// discrete 3D Frictional Contact problems, INRIA RT-0444, 2014). This rank's part.
struct LocalProblem {
  std::string title;
  std::int64_t contacts = 0;  ///< over all ranks
  DelassusMatrix matrix;
  Ghosts rows;          ///< owned contacts, no ghosts
  std::vector<Vec3> q;  ///< in the order n, t1, t2
  std::vector<double> mu;
  std::vector<Vec3> solution;  ///< the file's own r; empty where it has none

  ContactProblem view() const;

 private:
  friend LocalProblem read_fclib(const std::string& path, const Comm& comm);
  std::vector<double> zero_;
  std::vector<Index> index_, ground_;
  std::vector<Vec3> normal_;
};

/// W as triplets or compressed rows or columns (it is symmetric). Throws Error, with file and
/// dataset, on what is missing, not finite, of the wrong size, or not a problem in three
/// dimensions without bilateral constraints. Collective.
LocalProblem read_fclib(const std::string& path, const Comm& comm);

}  // namespace spall
