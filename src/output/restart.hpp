// Restart files: the whole state of a run between two steps, bit for bit.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "pairs/bonds.hpp"
#include "spall/bodies.hpp"
#include "spall/comm.hpp"
#include "state/contact_memory.hpp"

namespace spall {

/// Where a run stands: so many steps are done.
struct Clock {
  std::int64_t step = 0;           ///< since the start
  std::int64_t phase = 0;          ///< index into the case's phases
  std::int64_t step_in_phase = 0;  ///< done in this phase
  double time = 0;                 ///< s since the start
  double time_in_phase = 0;        ///< s
  double since_impact = -1;        ///< s since the impactor was added; negative: not yet

  /// Of the last step; of the first where there was none. Its engine stands, and its step tells
  /// what instants are seen, until another phase has begun.
  std::int64_t phase_of_last_step() const { return phase - (step_in_phase == 0 && phase > 0); }
};

/// Whatever must go on beside bodies, contacts and clock, by name.
using Scalars = std::map<std::string, double>;

/// An Error where the restart file has no such entry.
double find_scalar(const Scalars& scalars, const std::string& name);

/// Both go through `Self::for_each_scalar(self, f)`, which calls f(name, value) for what it keeps.
template <class Self>
void save_scalars(const Self& self, Scalars& scalars) {
  Self::for_each_scalar(
      self, [&](const std::string& name, auto v) { scalars[name] = static_cast<double>(v); });
}
template <class Self>
void load_scalars(Self& self, const Scalars& scalars) {
  Self::for_each_scalar(self, [&]<class T>(const std::string& name, T& v) {
    v = static_cast<T>(find_scalar(scalars, name));
  });
}

/// Everything that a run needs to go on. Bodies and contacts are this rank's, in its own order.
struct RestartState {
  std::string case_file;               ///< where the case was read
  std::string case_text;               ///< as it was read
  std::vector<std::string> overrides;  ///< "key.path=value", as given to --set
  bool overridden = false;             ///< by who goes on with it; not in the file
  std::vector<std::string> constants;  ///< of materials, as `Case::constants`
  Clock clock;
  Scalars scalars;
  Vec3 period = Vec3::Zero();  ///< m, `Period::size`: for packings of bodies that overlap round it
  Bodies bodies;               ///< owned rows only
  SharedContacts contacts;     ///< at least once on some rank
  std::optional<Bonds> bonds;  ///< of the bodies, where bonds break and have been made
};

/// Replaces `path` as a whole: a run killed meanwhile leaves the former file. The former file stays
/// as `former_restart` names it. Collective.
void write_restart(const Comm& comm, const std::string& path, const RestartState& state);

/// Removes a file that is damaged, before a run writes there: it would become the one before, in
/// place of the whole one from which the run goes on. Collective.
void remove_unless_whole(const Comm& comm, const std::string& path);

/// The generation before: <name>_before.h5 beside <name>.h5.
std::string former_restart(const std::string& path);

/// On as many ranks as wrote it each rank gets its own rows back in their order; otherwise equal
/// parts of all rows, to be moved to where they belong. An Error says what is wrong with the file.
/// Collective.
RestartState read_restart(const Comm& comm, const std::string& path);

}  // namespace spall
