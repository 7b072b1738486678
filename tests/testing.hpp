// What every test shares: communicators, and what errors say.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>

#include "spall/comm.hpp"
#include "spall/error.hpp"

namespace spall {

Comm testing_world();

/// Of this rank: for what every rank computes by itself.
inline Comm alone() {
  return Comm(MPI_COMM_SELF);
}

/// What the Error says in which `f` ends; empty where it ends in none.
template <class F>
std::string complaint_of(F&& f) {
  try {
    f();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

}  // namespace spall
