// How bodies are shared out to the ranks.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace spall {

/// Space is halved again and again, or METIS cuts the graph of coarse cells of space.
enum class Cut { bisection, metis };

}  // namespace spall
