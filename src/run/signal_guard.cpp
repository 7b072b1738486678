// The handler leaves a note only.
// SPDX-License-Identifier: BSD-3-Clause
#include "run/signal_guard.hpp"

#include <iterator>

namespace spall {
namespace {

constexpr int numbers[] = {SIGCONT, SIGINT, SIGTERM, SIGHUP, SIGUSR1, SIGUSR2, SIGXCPU};

volatile std::sig_atomic_t stop_asked = 0, warning_given = 0;
void catch_signal(int number) {
  (number == SIGCONT ? warning_given : stop_asked) = 1;
}

}  // namespace

SignalGuard::SignalGuard() {
  static_assert(std::size(numbers) == count_);
  stop_asked = 0;
  warning_given = 0;
  struct sigaction ours = {};
  ours.sa_handler = catch_signal;
  ours.sa_flags = SA_RESTART;
  for (int k = 0; k < count_; ++k) {
    sigaction(numbers[k], nullptr, &before_[k]);
    if (before_[k].sa_handler != SIG_IGN) sigaction(numbers[k], &ours, nullptr);
  }
}

SignalGuard::~SignalGuard() {
  for (int k = 0; k < count_; ++k) sigaction(numbers[k], &before_[k], nullptr);
}

bool SignalGuard::stops() const {
  return stop_asked != 0;
}

bool SignalGuard::warned() const {
  return warning_given != 0;
}

void SignalGuard::forget_warning() {
  warning_given = 0;
}

}  // namespace spall
