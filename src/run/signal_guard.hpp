// A signal ends a run between two steps, after a restart file.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <csignal>

namespace spall {

/// Catches signals while it lives, but for those that are ignored, as SIGHUP under nohup.
///
/// SIGINT, SIGTERM, SIGHUP, SIGUSR1, SIGUSR2 and SIGXCPU ask to stop. SIGCONT is a warning: mpirun
/// and Slurm send it first to what they are about to end. Whether the end follows is not known, for
/// a run that was suspended is woken by it too.
class SignalGuard {
 public:
  SignalGuard();
  ~SignalGuard();
  SignalGuard(const SignalGuard&) = delete;
  SignalGuard& operator=(const SignalGuard&) = delete;

  bool stops() const;   ///< on this rank
  bool warned() const;  ///< on this rank, since the last `forget_warning`
  void forget_warning();

 private:
  static constexpr int count_ = 7;
  struct sigaction before_[count_];
};

}  // namespace spall
