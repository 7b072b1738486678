// Linux tells it in pages.
// SPDX-License-Identifier: BSD-3-Clause
#include "base/resident.hpp"

#include <unistd.h>

#include <fstream>

namespace spall {

double resident_bytes() {
  std::ifstream file("/proc/self/statm");
  double all = 0, resident = 0;
  file >> all >> resident;
  return file ? resident * static_cast<double>(sysconf(_SC_PAGESIZE)) : 0;
}

}  // namespace spall
