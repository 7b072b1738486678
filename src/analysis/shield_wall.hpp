// Whether a wall has held: what is left of it seen along its normal, and what has left its rear.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "pairs/links.hpp"
#include "scene/case.hpp"
#include "spall/comm.hpp"

namespace spall {

/// Places are told along the normal of a wall, from its middle towards its rear, and across it.
struct WallFrame {
  Vec3 center = Vec3::Zero();   ///< m
  Vec3 normal = Vec3::UnitZ();  ///< to the rear
  std::array<Vec3, 2> across = {};
};

/// A wall as the case laid it.
struct ShieldWall {
  std::string name, section;  ///< of the group; of the results
  std::int32_t group = 0;
  WallFrame start;
  double thickness = 0;                ///< m
  std::array<double, 2> half_width{};  ///< m, across
  bool round = false;                  ///< a disc
  double spacing = 0;   ///< m, of its bodies, or of a 400th of its width where that is more: what
                        ///< can be seen of it
  double distance = 0;  ///< m, of its bodies from their neighbours
  double density = 0;   ///< kg/m^3
  double columns = 0;   ///< 1/m^2, bodies behind each other where it is whole: the median
  struct Approach {
    std::int32_t group;
    double speed;    ///< m/s at the start, towards the wall
    double clear;    ///< m from the wall's middle, from which on it is told what flies at it
    double density;  ///< kg/m^3
  };
  std::vector<Approach> approaches;  ///< what flies at it
};

/// Throws Error where the wall has an opening before anything has met it. Collective.
ShieldWall lay_wall(const Comm& comm, const Case& scene, const Shield& shield);

enum class Outcome { held, detached_spall, perforated };
const char* name_of(Outcome outcome);

/// Judged is its main piece: the heaviest of those whose bodies hang together by links. It is seen
/// along its own normal, about its own centre of mass, wherever it has gone. A rim of a tenth of
/// the half width, or of two spacings where that is more, is not judged.
///
/// It is perforated where a sphere as large as its bodies could pass along the normal without
/// touching that piece. An opening is what such a sphere can sweep. Else spall has detached where
/// other pieces lie behind the piece's rear surface, by more than a spacing, single bodies by more
/// than two, and move away from it, together at least as heavy as four bodies: so many lie in one
/// layer of the smallest opening. Pieces that come from the rim are not judged either.
struct WallVerdict {
  Outcome outcome = Outcome::held;
  double margin = 0;    ///< of the thickness. Held: the thinnest part. Spall: minus the diameter
                        ///< of a ball of it. Perforated: minus that of the largest opening
  double thinnest = 0;  ///< m, of the main piece, over a circle of one and a half spacings
  double hole = 0;      ///< m, diameter of a circle as large as the largest opening
  std::int64_t openings = 0;
  bool opening_at_edge = false;              ///< one reaches the rim
  std::int64_t spall_pieces = 0;             ///< behind the rear, moving away; single bodies, too
  double spall_mass = 0, spall_largest = 0;  ///< kg
  double rim_mass = 0;                       ///< kg, the same from the rim, which is not judged
  double least_spall = 0;                    ///< kg, from which on it counts
  double spall_speed = 0;                    ///< m/s, against the main piece, mean by mass
  double still_coming = 0;  ///< share of the energy that flew at it of what is yet to meet it
};
/// What has left a wall that holds has left it, whatever stopped it behind: `most` is the verdict
/// of the look that saw most spall leave until now.
void keep_spall(WallVerdict& most, WallVerdict& verdict);

/// Velocities and positions must belong to the same instant. Collective.
WallVerdict judge_wall(const Comm& comm, const LinkedBodies& linked, const ShieldWall& wall);

/// J, of motion along the normal: of the piece that has most, of what flies at the wall and is in
/// the last quarter of its way from the plate before it. It will meet what is judged, or fly past
/// that.
struct Coming {
  double meets = 0, passes = 0;
  double diameter = 0, density = 0;  ///< m, of a ball as heavy as that which meets it; kg/m^3
  /// m, full widths of an ellipsoid as heavy, in proportion to its radii of gyration, the widest
  /// first; rad, the rotation vector that turns it from the axes of coordinates.
  Vec3 size = Vec3::Zero(), rotation = Vec3::Zero();
  Vec3 velocity = Vec3::Zero();  ///< m/s, against the wall

  /// The more energetic of what two looks saw.
  void add(const Coming& other);
};
/// Whether so few of the wall's bodies lie across that piece that its verdict may be another with
/// smaller ones. A wall that is thick beside it holds anyway.
bool is_coarse(const ShieldWall& wall, const Coming& coming);
/// The same holds. Collective.
Coming look_at_what_comes(const Comm& comm, const LinkedBodies& linked, const ShieldWall& wall);

}  // namespace spall
