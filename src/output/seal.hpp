// A seal before the first byte of an HDF5 file: its size and the checksum of all that follows.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>

#include "spall/comm.hpp"

namespace spall {

/// Bytes of the seal: the least user block that HDF5 allows before its own.
inline constexpr std::size_t seal_size = 512;

/// Seals the closed file `path`, whose first `seal_size` bytes are free. Each rank reads an equal
/// part of it. Collective.
void seal(const Comm& comm, const std::string& path);

/// Throws Error, on all ranks, unless each byte is as it was sealed, before HDF5 sees any.
/// Collective.
void check_seal(const Comm& comm, const std::string& path);

/// Whether HDF5's own bytes come first: then others wrote it, and there is no seal to check.
bool begins_as_hdf5(const std::string& path);

}  // namespace spall
