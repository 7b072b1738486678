// The program: one catch, one exit.
// SPDX-License-Identifier: BSD-3-Clause
#include "spall/base/comm.hpp"

int main(int argc, char** argv) {
  spall::Session session(argc, argv);
  return 0;
}
