// GoogleTest under MPI: every rank runs every test; all ranks agree on failure.
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "testing.hpp"

namespace {
spall::Comm the_world;
}

spall::Comm spall::testing_world() {
  return the_world;
}

int main(int argc, char** argv) {
  spall::Session session;
  the_world = session.world();
  ::testing::InitGoogleTest(&argc, argv);
  if (the_world.rank != 0) {
    // One voice: the other ranks speak only when something fails.
    auto& listeners = ::testing::UnitTest::GetInstance()->listeners();
    delete listeners.Release(listeners.default_result_printer());
    struct Failures : ::testing::EmptyTestEventListener {
      void OnTestPartResult(const ::testing::TestPartResult& result) override {
        if (result.failed())
          fmt::print(stderr, "rank {}: {}:{}: {}\n", the_world.rank,
                     result.file_name() ? result.file_name() : "?", result.line_number(),
                     result.summary());
      }
    };
    listeners.Append(new Failures);
  }
  return the_world.any(RUN_ALL_TESTS() != 0) ? 1 : 0;
}
