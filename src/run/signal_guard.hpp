// A signal ends a run between two steps, after a restart file.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace spall {

/// Catches SIGINT, SIGTERM and SIGUSR1 while it lives. mpirun hands on SIGUSR1 as it is, but kills
/// a second after it handed on SIGINT or SIGTERM.
class SignalGuard {
 public:
  SignalGuard();
  ~SignalGuard();
  SignalGuard(const SignalGuard&) = delete;
  SignalGuard& operator=(const SignalGuard&) = delete;

  bool caught() const;  ///< on this rank

 private:
  static constexpr int count_ = 3;
  void (*before_[count_])(int);
};

}  // namespace spall
