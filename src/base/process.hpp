// What the system tells of this process.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace spall {

/// Bytes of this process that lie in memory; 0 where the system does not tell.
double resident_bytes();

/// Of the machine that it runs on.
std::string host_name();

/// The words by which it was called, for a shell to read: of `spall` or of a program that uses it.
std::string command_line();

}  // namespace spall
