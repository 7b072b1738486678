// How long the parts of a step may last, and which bodies may go by longer ones.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "solid/engine.hpp"
#include "state/world.hpp"

namespace spall {

/// Of impacts the energy that second order loses decides: with a fifth of a spacing a third of a
/// percent at 6.7 km/s, four times that in steps twice as long (cases/plate_solid).
inline constexpr double share_of_impacts = 4;

/// Of all ranks.
struct PartBounds {
  double slope = 0;      ///< the largest of the shock speeds
  double narrowest = 0;  ///< m, spacing
  double seen = 0;       ///< m: the gap in which those that meet are seen and do not touch yet
};
/// Collective.
PartBounds part_bounds(const World& world, const Elastoplastic& engine);

/// Finds `Elastoplastic::waves` of these bodies, with what compression and heat add where there are
/// neighbours: else the pressure moves nothing.
void find_waves(const World& world, Elastoplastic& engine, std::span<const Index> which);

/// 1/s, v/R at most, of owned bodies that move at v against what is nearer than their reach R:
/// another body of any piece, or a wall. With pairs, rows and `fastest_pair2` current.
double fastest_meeting(const World& world, const Elastoplastic& engine);

/// s: the longest part for bodies whose sound crosses the share `waves` of a spacing in a second
/// (1/s), and which meet others at v/R = `meeting` (1/s).
double longest_part(const Elastoplastic& engine, const PartBounds& bounds, double waves,
                    double meeting);

/// s, of owned bodies: the longest part that each allows; infinite of those that rest. `meeting2`:
/// the largest v^2/R^2 (1/s^2) of neighbours of one piece.
std::vector<double> longest_parts(const World& world, const Elastoplastic& engine,
                                  const PartBounds& bounds, std::vector<double> meeting2);

struct Stride {
  int parts = 1;    ///< 1: none is slow
  double work = 1;  ///< a part, of one in which all act
};
/// The cheapest stride of up to `most` parts that last `part` (s) each, where bodies allow parts of
/// up to `limit` (s, one an owned body; infinite: it does not act). Counted, not timed, so that a
/// run gives the same bits again. Collective.
Stride cheapest_stride(const Comm& comm, const std::vector<double>& limit, double part,
                       double most);

}  // namespace spall
