// What every test shares: the communicator of the run.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "spall/base/comm.hpp"

namespace spall {

Comm testing_world();

}  // namespace spall
