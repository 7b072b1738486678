// What ranks pay for telling each other something.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>

#include "spall/comm.hpp"

namespace spall {

/// Between two ranks: a message of n bytes takes latency + n / bandwidth.
struct Network {
  double latency = 2e-6;   ///< s
  double bandwidth = 1e9;  ///< bytes/s, of one rank while all of its node talk
};

/// By messages to and fro between the first two ranks. Throws Error on one rank. Collective.
Network measure_network(const Comm& comm);

/// bytes/s of "10 GB/s". Throws Error where it is none.
double parse_bandwidth(std::string_view text);

}  // namespace spall
