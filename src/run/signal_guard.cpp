// The handler leaves a note only.
// SPDX-License-Identifier: BSD-3-Clause
#include "run/signal_guard.hpp"

#include <csignal>
#include <iterator>

namespace spall {
namespace {

constexpr int numbers[] = {SIGINT, SIGTERM, SIGUSR1};

volatile std::sig_atomic_t signal_caught = 0;
void catch_signal(int number) {
  signal_caught = number;
}

}  // namespace

SignalGuard::SignalGuard() {
  static_assert(std::size(numbers) == count_);
  signal_caught = 0;
  for (int k = 0; k < count_; ++k) before_[k] = std::signal(numbers[k], catch_signal);
}

SignalGuard::~SignalGuard() {
  for (int k = 0; k < count_; ++k) std::signal(numbers[k], before_[k]);
}

bool SignalGuard::caught() const {
  return signal_caught != 0;
}

}  // namespace spall
