// Pieces that meet, and walls: they push, and nothing else.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "solid/law.hpp"
#include "solid/rows.hpp"
#include "solid/sweep.hpp"
#include "state/world.hpp"

namespace spall {

/// Two bodies of different pieces push each other apart where they are nearer than d, the sum of
/// their radii. With eta = 1 - r/d, and A such that a crystal of such contacts had the bulk modulus
/// K, in series of both,
///
///   F = A (P(eta) + q),   P = K eta/(1 - s eta)^2,   q = rho (c0 u + s u^2),   A = 18 V/(12 d),
///
/// V = d^3/sqrt(2) with the smaller of both diameters: fine bodies on a coarse one press by the
/// share of its face that each covers. u is the closing speed that is left where velocities are
/// extrapolated by the bodies' gradients, limited as in `sweep_forces`. There is no friction.
class ContactPush {
 public:
  ContactPush(const SolidLaw& a, const SolidLaw& b, double distance, double smaller);

  double force(double r) const;          ///< N, without q
  double energy(double r) const;         ///< J
  double viscous(double closing) const;  ///< N; 0 where bodies part

 private:
  double distance_, area_, modulus_, slope_, density_, speed_;
};

/// Rows of near bodies of different pieces, one an owned one.
struct PieceContact {
  Index i, j;
};
/// An owned body near a wall, which acts on it as a contact does, at r = height + d/2. The wall
/// stands still, and the speed at which the body closes is not limited.
struct WallContact {
  Index row;
  std::int32_t wall;
};

struct SolidContacts {
  std::vector<PieceContact> pieces;
  std::vector<WallContact> walls;
};

/// Of the pairs found, those of different pieces that are neighbours, or will be once they come
/// nearer by `skin` (m); and bodies up to `skin` beyond a wall's push.
SolidContacts find_contacts(const World& world, const std::vector<NearWindow>& windows,
                            double skin);

/// Adds impulses in a part of `h` (s), and what becomes heat. Walls receive the opposite. A contact
/// acts as often as the one of its bodies that does so more often.
void push_by_contacts(World& world, const std::vector<SolidLaw>& laws,
                      const SolidContacts& contacts, double h, const MotionRow* rows,
                      const ResponseRow* responses, PushRow* impulses);

/// J on this rank; a contact with a ghost counts half.
double energy_of_contacts(const World& world, const std::vector<SolidLaw>& laws,
                          const SolidContacts& contacts, const MotionRow* rows);

}  // namespace spall
