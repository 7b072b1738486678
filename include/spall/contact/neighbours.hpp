// Who is near whom: ghosts and pairs that stay valid while bodies move less than their reach.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "spall/base/comm.hpp"
#include "spall/contact/broad_phase.hpp"
#include "spall/domain/ghosts.hpp"
#include "spall/domain/partition.hpp"
#include "spall/scene/bodies.hpp"

namespace spall {

struct Neighbours {
  Ghosts ghosts;
  Pairs pairs;
  ContactMemory carried;        ///< impulses to start from, of a restart; taken by the next search
  bool valid = false;           ///< false: search before the next step, as after a change of bodies
  std::vector<Vec3> found_at;   ///< m, owned rows: where bodies were when the pairs were found
  std::vector<double> reach;    ///< m: how far a body may come from there, a step's motion included
  Vec3 drift = Vec3::Zero();    ///< m/s: motion that all share, on top of that
  Vec3 drifted = Vec3::Zero();  ///< m: by which places have moved with it since
  LastCut last_cut;
};

/// Makes ghosts and pairs current for a step `h` (s): copies the ghosts' new state, and where a
/// body might leave its reach searches pairs anew; before a search cuts the domain anew where the
/// ranks' work (bodies and contacts) differs by more than a tenth. Impulses stay with their pairs.
/// Collective.
void update_neighbours(const Comm& comm, Bodies& bodies, const std::vector<Plane>& planes, double h,
                       double cohesion_range, Neighbours& neighbours);

}  // namespace spall
