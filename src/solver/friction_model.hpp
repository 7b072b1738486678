// What is taken for friction between bodies.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace spall {

/// Coulomb's law as it is, or its convex relaxation (Anitescu & Tasora, Comput. Optim. Appl. 47
/// (2010) 207), in which contacts that slide also part.
enum class FrictionModel { convex, coulomb };

}  // namespace spall
