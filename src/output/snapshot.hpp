// Snapshots of all bodies for pictures and analysis: H5MD files that ParaView, VisIt and h5py open.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "output/provenance.hpp"
#include "scene/case.hpp"
#include "spall/bodies.hpp"
#include "spall/comm.hpp"

namespace spall {

namespace h5 {
class File;
}

/// What snapshots may hold of each body, with units: for `spall keys`.
std::string describe_output_fields();

/// What the numbers of a field stand for; nothing for most.
using FieldNames = std::array<std::vector<std::string>, field_table.size()>;

/// Writes, into `folder`,
///   snapshots/000000.h5 …   one H5MD 1.1 file a snapshot, written by all ranks together; row k of
///                           every dataset is body k on any number of ranks
///   trajectory.h5           all of them as one H5MD file, by virtual datasets; a body that is not
///                           there yet has id -1, NaN and -1; what is fixed is that of the last
///   trajectory.xdmf         the same for ParaView and VisIt
///
/// `temperature` stands beside the fields of the bodies where a material has a specific heat.
///
/// HDF5 cannot promise a readable file to a process that dies while it writes, so each snapshot is
/// a file of its own that takes its name only when it is complete. The other two are an index,
/// replaced whole while the run goes on (the last few of many snapshots may be missing) and at its
/// end.
class SnapshotWriter {
 public:
  /// Looks for the first `kept` snapshots, on resuming: where one of these is lost or cannot be
  /// read, an Error names it. A folder without snapshots begins anew. Collective.
  SnapshotWriter(Comm comm, std::string folder, const Case& scene, Provenance provenance,
                 std::int64_t kept = 0);

  /// Removes the snapshots of an earlier run that follow those. Before the first is written.
  /// Collective.
  void begin();

  /// Ids of the owned bodies of all ranks are 0 … N-1, in any distribution. Where the case asks for
  /// a map of gravity, the file holds it as /fields/gravity: potential and acceleration, row k at
  /// point k of the grid, whose counts, low corner (m) and spacing (m) are there too. Collective.
  void write(const Bodies& bodies, std::int64_t step, double time);
  /// Brings the trajectory up to the last snapshot: for the end of a run.
  void write_index();
  std::int64_t count() const { return std::ssize(written_); }
  /// Of the last one; negative where none is.
  std::int64_t last_step() const { return written_.empty() ? -1 : written_.back().step; }

 private:
  struct Written {
    std::int64_t step;
    double time;  // s
    std::int64_t rows;
  };
  /// The fields of the bodies, and the temperature of those whose material has a specific heat.
  template <class F>
  void for_each_output(const Bodies& bodies, F&& f) const;
  void find_written(std::int64_t kept);
  void write_metadata(h5::File& file) const;
  void write_gravity(h5::File& file, const Bodies& bodies) const;
  void write_trajectory() const;
  void write_xdmf() const;

  Comm comm_;
  std::string folder_;
  Provenance provenance_;
  std::vector<Material> materials_;
  FieldNames names_;
  BodyShapes shapes_;
  Period period_;
  GravitySettings gravity_;
  std::optional<Grid> map_;
  FieldSet fields_;                            // of the bodies, as last written
  std::vector<Written> written_;               // the same on all ranks
  std::size_t indexed_ = 0;                    // how many of them the index has
  std::vector<std::filesystem::path> others_;  // of an earlier run, on rank 0
};

}  // namespace spall
