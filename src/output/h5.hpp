// HDF5 as three verbs: a file that closes itself, rows written and rows read by all ranks.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <hdf5.h>

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "spall/comm.hpp"
#include "spall/types.hpp"

namespace spall::h5 {

/// Throws `Error` with the innermost message of HDF5's error stack.
[[noreturn]] void fail(const char* call, const std::string& name);

/// Passes a return code or identifier on unless it says failure.
template <class Code>
Code check(Code code, const char* call, const std::string& name) {
  if (code < 0) fail(call, name);
  return code;
}

/// An HDF5 identifier that closes itself. Not where an error is on its way through a file of
/// several ranks: to close talks to ranks that may not be there, and the error would never be said.
/// What was written is closed by `finish`: small values reach the disk only then.
class Handle {
 public:
  using Close = herr_t (*)(hid_t);
  Handle() = default;
  Handle(hid_t id, Close close) : id_(id), close_(close) {}
  ~Handle() { reset(); }
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Handle& operator=(Handle&& other) noexcept {
    reset();
    id_ = std::exchange(other.id_, -1);
    close_ = other.close_;
    return *this;
  }
  operator hid_t() const { return id_; }
  hid_t release() { return std::exchange(id_, -1); }
  void finish(const char* call, const std::string& name);  ///< closes, or throws Error

 private:
  void reset();
  hid_t id_ = -1;
  Close close_ = nullptr;
};

/// How a C++ value lies in a file: its HDF5 type and how many of them make one row.
template <class T>
struct Layout;
template <>
struct Layout<double> {
  static hid_t type() { return H5T_NATIVE_DOUBLE; }
  static constexpr hsize_t width = 1;
};
template <>
struct Layout<std::int32_t> {
  static hid_t type() { return H5T_NATIVE_INT32; }
  static constexpr hsize_t width = 1;
};
template <>
struct Layout<std::int64_t> {
  static hid_t type() { return H5T_NATIVE_INT64; }
  static constexpr hsize_t width = 1;
};
template <>
struct Layout<Vec3> {
  static hid_t type() { return H5T_NATIVE_DOUBLE; }
  static constexpr hsize_t width = 3;
};

template <>
struct Layout<Quaternion> {
  static hid_t type() { return H5T_NATIVE_DOUBLE; }
  static constexpr hsize_t width = 4;
};
template <>
struct Layout<std::array<std::int32_t, 2>> {
  static hid_t type() { return H5T_NATIVE_INT32; }
  static constexpr hsize_t width = 2;
};

/// This rank's rows [begin, begin + count) of a dataset with `total` rows.
struct Rows {
  hsize_t begin = 0, count = 0, total = 0;
  hsize_t end() const { return begin + count; }
};
/// Ranks write one after another, `count` rows each. Collective.
Rows rows_in_rank_order(const Comm& comm, std::size_t count);
/// The `rank`-th of `ranks` nearly equal parts.
Rows equal_rows(int rank, int ranks, hsize_t total);

/// The first `rows` rows of the dataset of the same name in `file`, beside the viewing file.
struct Source {
  std::string file;
  hsize_t rows;
};

using Names = std::vector<std::string>;

/// A file of all ranks of a communicator, or of this rank alone. Names are paths inside the file;
/// missing groups are made. On a file of all ranks every call is collective, and where one rank
/// cannot write, it says so and ends all: HDF5 would leave the others waiting.
class File {
 public:
  /// `free` bytes stay free before HDF5's own: 0, or a power of two from 512 on.
  static File create(const std::string& path, hsize_t free = 0);
  static File create(const std::string& path, const Comm& comm, hsize_t free = 0);
  static File open(const std::string& path);
  static File open(const std::string& path, const Comm& comm);
  void close();  ///< reports what the destructor would swallow

  hid_t id() const { return file_; }

  /// An MPI error handler of files.
  static void end_all(MPI_File* file, int* code, ...);

  void group(const std::string& name);
  /// Attributes of the object `name`.
  void attribute(const std::string& name, const char* key, const std::string& text);
  void attribute(const std::string& name, const char* key, int value);
  void attribute(const std::string& name, const char* key, std::span<const int> values);
  void attribute(const std::string& name, const char* key, std::span<const std::string> texts);
  /// A second name for an object of this file, and one for an object of another file.
  void link(const std::string& object, const std::string& name);
  void link_outside(const std::string& file, const std::string& object, const std::string& name);
  /// A scalar string; the same on all ranks.
  void write_text(const std::string& name, const std::string& text);
  /// Where the dataset holds something else than one text of fixed length, an Error.
  std::string read_text(const std::string& name) const;

  /// Writes this rank's rows; the dataset is (total) or (total, width), with `as_frame` (1, total,
  /// …). Integers with `names` are an enumeration, in which names[k] stands for k.
  template <class T>
  void write(const std::string& name, std::span<const T> values, const Rows& rows,
             bool as_frame = false, const Names& names = {}) {
    write_rows(name, Layout<T>::type(), Layout<T>::width, values.data(), rows, as_frame, names);
  }
  /// A small array that is the same on all ranks.
  template <class T>
  void write(const std::string& name, std::span<const T> values) {
    write_same(name, Layout<T>::type(), Layout<T>::width, values.data(), values.size());
  }
  /// A dataset (`total` rows) whose rows lie in other files; with `as_frames` (one frame a source,
  /// `total`, …). Rows that a source lacks read as NaN or -1. For files of this rank alone.
  template <class T>
  void write_view(const std::string& name, std::span<const Source> sources, hsize_t total,
                  bool as_frames, const Names& names = {}) {
    write_view_raw(name, Layout<T>::type(), Layout<T>::width, sources, total, as_frames, names);
  }
  bool exists(const std::string& name) const;
  hsize_t total_rows(const std::string& name) const;
  /// Reading throws Error where the dataset holds another kind of values, another number of them,
  /// or fewer bytes than it says.
  template <class T>
  std::vector<T> read(const std::string& name, const Rows& rows) const {
    check_values(name, Layout<T>::type(), Layout<T>::width, rows);
    std::vector<T> values(rows.count);
    if (rows.total > 0) read_raw(name, Layout<T>::type(), Layout<T>::width, values.data(), rows);
    return values;
  }
  /// All values in a row, on every rank.
  template <class T>
  std::vector<T> read(const std::string& name) const {
    std::vector<T> values(check_values(name, Layout<T>::type(), Layout<T>::width, {}) /
                          Layout<T>::width);
    if (!values.empty()) read_raw(name, Layout<T>::type(), Layout<T>::width, values.data(), {});
    return values;
  }

 private:
  File(Handle file, const Comm* comm, std::string path);
  /// Counts the files of several ranks that are open.
  struct Shared {
    Shared() { ++open; }
    Shared(Shared&&) noexcept { ++open; }
    ~Shared() {
      if (--open == 0) written.clear();
    }
    static inline int open = 0;
    static inline std::string written;  // the one that was created last; empty: none
  };
  friend class Handle;
  /// No shape: a scalar.
  void add_attribute(const std::string& name, const char* key, hid_t type,
                     std::span<const hsize_t> shape, const void* value);
  void write_rows(const std::string& name, hid_t type, hsize_t width, const void* values,
                  const Rows& rows, bool as_frame, const Names& names);
  void write_same(const std::string& name, hid_t type, hsize_t width, const void* values,
                  hsize_t count);
  Handle create_dataset(const std::string& name, hid_t type, hsize_t width, hsize_t rows,
                        bool as_frame);
  void write_view_raw(const std::string& name, hid_t type, hsize_t width,
                      std::span<const Source> sources, hsize_t total, bool as_frames,
                      const Names& names);
  void read_raw(const std::string& name, hid_t type, hsize_t width, void* values,
                const std::optional<Rows>& rows) const;
  /// How many values there are, all of a kind and number that can be asked for.
  hsize_t check_values(const std::string& name, hid_t type, hsize_t width,
                       const std::optional<Rows>& rows) const;
  std::string place(const std::string& name) const { return path_ + ":" + name; }

  std::optional<Shared> shared_;  // outlives the handles
  Handle file_;
  Handle transfer_;     // collective where the file is of all ranks
  bool leader_ = true;  // this rank alone writes what is the same on all ranks
  std::string path_;
};

/// The group that makes a file H5MD 1.1 (de Buyl, Colberg & Hoefling 2014), with units of the SI.
void write_h5md(File& file);

}  // namespace spall::h5
