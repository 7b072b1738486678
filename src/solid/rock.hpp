// How a cracked body's shear stress is shared between what is intact and what slides.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

#include "solid/law.hpp"

namespace spall {

/// Of a body with damage D both shares are strained alike. The intact one bears the deviator t, up
/// to its strength; the cracked one slides where that is more than it bears by friction, Y_d:
///
///   s = (1 - D) t + D min(1, Y_d/|t|) t .
///
/// So a body yields at (1 - D) Y_i + D Y_d, as Collins, Melosh & Ivanov (Meteorit. Planet. Sci. 39
/// (2004) 217) blend the strengths. In tension Y_d = 0: cracks are open. All in Pa, as von Mises'
/// stress. Returns |t| of a body that bears |s| = `mises` at this pressure.
inline double intact_stress(const SolidLaw& law, double damage, double mises, double pressure) {
  const double slides = law.sliding_strength(pressure);
  if (mises <= slides || damage >= 1) return mises;
  const double stress = (mises - damage * slides) / (1 - damage);
  // Where little is intact, rounding counts much.
  return law.rock.known() ? std::min(stress, std::max(mises, law.intact_strength(pressure)))
                          : stress;
}

}  // namespace spall
