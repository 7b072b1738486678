// What a rank tells others: messages, bytes and collective calls, counted where they are made.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>

namespace spall {

/// Of one rank, since some instant. PETSc's and HDF5's calls of their own are not counted.
struct Traffic {
  std::int64_t messages = 0;     ///< sent to single ranks
  std::int64_t bytes = 0;        ///< sent in them
  std::int64_t collectives = 0;  ///< reductions, gathers, broadcasts, searches for senders
  std::int64_t delayed = 0;      ///< of these, whose answer has a pass of work to arrive
  std::int64_t reduced = 0;      ///< bytes that reductions took from each rank
  std::int64_t gathered = 0;     ///< bytes that gathers from all ranks brought
  std::int64_t sources = 0;      ///< most ranks from which one exchange received
  // Counted where there are no ghosts, too: what more ranks would send follows from one.
  std::int64_t exchanges = 0;  ///< of ghosts' rows
  std::int64_t row_bytes = 0;  ///< of one row in all of them

  void add(const Traffic& other) {
    messages += other.messages;
    bytes += other.bytes;
    collectives += other.collectives;
    delayed += other.delayed;
    reduced += other.reduced;
    gathered += other.gathered;
    sources = std::max(sources, other.sources);
    exchanges += other.exchanges;
    row_bytes += other.row_bytes;
  }
  /// A part of it that was counted elsewhere, too.
  void take_away(const Traffic& part) {
    messages -= part.messages;
    bytes -= part.bytes;
    collectives -= part.collectives;
    delayed -= part.delayed;
    reduced -= part.reduced;
    gathered -= part.gathered;
    exchanges -= part.exchanges;
    row_bytes -= part.row_bytes;
  }
};

/// This rank's. Whoever wants a stage's own takes what is there and puts it back added.
Traffic& traffic();

}  // namespace spall
