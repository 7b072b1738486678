// Every HDF5 return code is checked here; HDF5's own printing is off, its words go into the Error.
// SPDX-License-Identifier: BSD-3-Clause
#include "output/h5.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <exception>
#include <limits>

#include "spall/error.hpp"

namespace spall::h5 {

namespace {

int cause_of_failed_write = 0;  // errno, of this rank alone

Handle make(hid_t id, Handle::Close close, const char* call, const std::string& name) {
  return Handle(check(id, call, name), close);
}

void silence() {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

/// Opens through MPI-IO where there is a communicator.
Handle access(const Comm* comm, const std::string& path) {
  silence();
  Handle list = make(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "H5Pcreate", path);
  if (comm) {
    static const bool once = [] {
      MPI_Errhandler handler = MPI_ERRHANDLER_NULL;
      check_mpi(MPI_File_create_errhandler(File::end_all, &handler), "MPI_File_create_errhandler");
      check_mpi(MPI_File_set_errhandler(MPI_FILE_NULL, handler), "MPI_File_set_errhandler");
      return true;
    }();
    static_cast<void>(once);
    check(H5Pset_fapl_mpio(list, comm->raw, MPI_INFO_NULL), "H5Pset_fapl_mpio", path);
    check(H5Pset_all_coll_metadata_ops(list, true), "H5Pset_all_coll_metadata_ops", path);
    check(H5Pset_coll_metadata_write(list, true), "H5Pset_coll_metadata_write", path);
  }
  return list;
}

Handle create_any(const std::string& path, const Comm* comm, hsize_t free) {
  Handle list = access(comm, path);
  Handle how = make(H5Pcreate(H5P_FILE_CREATE), H5Pclose, "H5Pcreate", path);
  check(H5Pset_userblock(how, free), "H5Pset_userblock", path);
  return make(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, how, list), H5Fclose, "H5Fcreate", path);
}

Handle open_any(const std::string& path, const Comm* comm) {
  Handle list = access(comm, path);
  return make(H5Fopen(path.c_str(), H5F_ACC_RDONLY, list), H5Fclose, "H5Fopen", path);
}

/// Link creation that makes missing groups on the way.
Handle with_parents(const std::string& name) {
  Handle list = make(H5Pcreate(H5P_LINK_CREATE), H5Pclose, "H5Pcreate", name);
  check(H5Pset_create_intermediate_group(list, 1), "H5Pset_create_intermediate_group", name);
  return list;
}

Handle text_type(std::size_t length, const std::string& name) {
  Handle type = make(H5Tcopy(H5T_C_S1), H5Tclose, "H5Tcopy", name);
  check(H5Tset_size(type, std::max<std::size_t>(length, 1)), "H5Tset_size", name);
  check(H5Tset_cset(type, H5T_CSET_UTF8), "H5Tset_cset", name);
  check(H5Tset_strpad(type, H5T_STR_NULLPAD), "H5Tset_strpad", name);
  return type;
}

/// `plain`, or where there are names their enumeration.
Handle type_of(hid_t plain, const Names& names, const std::string& name) {
  Handle type = names.empty() ? make(H5Tcopy(plain), H5Tclose, "H5Tcopy", name)
                              : make(H5Tenum_create(plain), H5Tclose, "H5Tenum_create", name);
  for (std::int32_t k = 0; k < std::ssize(names); ++k)
    check(H5Tenum_insert(type, names[k].c_str(), &k), "H5Tenum_insert", name);
  return type;
}

/// Memory and file selections of `rows`; a rank without rows takes part with none.
void select(hid_t memory, hid_t file, const Rows& rows, bool as_frame, hsize_t width,
            const std::string& name) {
  if (rows.count == 0) {
    check(H5Sselect_none(memory), "H5Sselect_none", name);
    check(H5Sselect_none(file), "H5Sselect_none", name);
    return;
  }
  std::array<hsize_t, 3> start{}, count{1, width, width};
  const int along = as_frame ? 1 : 0;  // the dimension of the rows
  start[along] = rows.begin;
  count[along] = rows.count;
  check(H5Sselect_hyperslab(file, H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr),
        "H5Sselect_hyperslab", name);
}

Handle memory_space(const Rows& rows, hsize_t width, const std::string& name) {
  const hsize_t size = std::max<hsize_t>(rows.count * width, 1);
  return make(H5Screate_simple(1, &size, nullptr), H5Sclose, "H5Screate_simple", name);
}

/// Throws Error where a dataset claims more bytes than it can have in the file: the claim alone
/// would take all memory.
void check_stored(hid_t set, hsize_t claimed, const std::string& name) {
  Handle how = make(H5Dget_create_plist(set), H5Pclose, "H5Dget_create_plist", name);
  if (claimed == 0 || H5Pget_layout(how) == H5D_VIRTUAL) return;  // its bytes are in other files
  constexpr double most_compressed = 1032;                        // by deflate
  const auto stored = static_cast<double>(H5Dget_storage_size(set));
  require(static_cast<double>(claimed) <= most_compressed * stored,
          "'{}' says that it holds {} bytes, but {:.0f} are there", name, claimed, stored);
}

}  // namespace

void fail(const char* call, const std::string& name) {
  std::string reason = "no reason given";
  H5Ewalk2(
      H5E_DEFAULT, H5E_WALK_UPWARD,
      [](unsigned depth, const H5E_error2_t* error, void* text) -> herr_t {
        if (depth == 0 && error->desc) *static_cast<std::string*>(text) = error->desc;
        return 0;
      },
      &reason);
  if (const int cause = std::exchange(cause_of_failed_write, 0)) reason = std::strerror(cause);
  // Of a failed system call HDF5 tells time, addresses and sizes, on two lines.
  const std::string before = "error message = '";
  if (const std::size_t at = reason.find(before); at != std::string::npos)
    reason = reason.substr(at + before.size(),
                           reason.find('\'', at + before.size()) - (at + before.size()));
  throw Error(fmt::format("{} of '{}' failed: {}", call, name, reason));
}

void Handle::finish(const char* call, const std::string& name) {
  check(close_(release()), call, name);
}

void Handle::reset() {
  const hid_t id = std::exchange(id_, -1);
  const bool others_may_be_gone = std::uncaught_exceptions() > 0 && File::Shared::open > 0;
  if (id >= 0 && !others_may_be_gone) close_(id);
}

/// What MPI calls where a rank cannot write; the system has told this rank why, or another one.
void File::end_all(MPI_File*, int* code, ...) {
  const std::string& path = Shared::written;
  constexpr int causes[] = {ENOSPC, EDQUOT, EFBIG, EIO};
  const int cause = std::ranges::find(causes, errno) == std::end(causes) ? 0 : errno;
  if (path.empty()) {  // HDF5 tells of these errors, but not why
    cause_of_failed_write = cause;
    return;
  }
  char text[MPI_MAX_ERROR_STRING] = "";
  int length = 0;
  MPI_Error_string(*code, text, &length);
  Session::abort_all(
      fmt::format("cannot write '{}': {}", path, cause ? std::strerror(cause) : text), cause != 0);
}

Rows rows_in_rank_order(const Comm& comm, std::size_t count) {
  const auto mine = static_cast<std::int64_t>(count);
  return {static_cast<hsize_t>(comm.sum_before(mine)), count, static_cast<hsize_t>(comm.sum(mine))};
}

Rows equal_rows(int rank, int ranks, hsize_t total) {
  const auto all = static_cast<std::int64_t>(total);
  const std::int64_t begin = part_begin(all, rank, ranks), end = part_begin(all, rank + 1, ranks);
  return {static_cast<hsize_t>(begin), static_cast<hsize_t>(end - begin), total};
}

File::File(Handle file, const Comm* comm, std::string path)
    : file_(std::move(file)), leader_(!comm || comm->rank == 0), path_(std::move(path)) {
  if (comm && comm->size > 1) shared_.emplace();
  transfer_ = make(H5Pcreate(H5P_DATASET_XFER), H5Pclose, "H5Pcreate", path_);
  if (comm) check(H5Pset_dxpl_mpio(transfer_, H5FD_MPIO_COLLECTIVE), "H5Pset_dxpl_mpio", path_);
}

File File::create(const std::string& path, hsize_t free) {
  return {create_any(path, nullptr, free), nullptr, path};
}
File File::create(const std::string& path, const Comm& comm, hsize_t free) {
  File file(create_any(path, &comm, free), &comm, path);
  if (comm.size > 1) Shared::written = path;
  return file;
}
File File::open(const std::string& path) {
  return {open_any(path, nullptr), nullptr, path};
}
File File::open(const std::string& path, const Comm& comm) {
  return {open_any(path, &comm), &comm, path};
}

void File::close() {
  check(H5Fclose(file_.release()), "H5Fclose", path_);
}

void File::group(const std::string& name) {
  make(H5Gcreate2(file_, name.c_str(), with_parents(place(name)), H5P_DEFAULT, H5P_DEFAULT),
       H5Gclose, "H5Gcreate2", place(name))
      .finish("H5Gclose", place(name));
}

void File::add_attribute(const std::string& name, const char* key, hid_t type,
                         std::span<const hsize_t> shape, const void* value) {
  const auto rank = static_cast<int>(shape.size());
  Handle object = make(H5Oopen(file_, name.c_str(), H5P_DEFAULT), H5Oclose, "H5Oopen", place(name));
  Handle space = make(H5Screate_simple(rank, shape.data(), nullptr), H5Sclose, "H5Screate_simple",
                      place(name));
  Handle attribute = make(H5Acreate2(object, key, type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
                          "H5Acreate2", place(name));
  check(H5Awrite(attribute, type, value), "H5Awrite", place(name));
  attribute.finish("H5Aclose", place(name));
  object.finish("H5Oclose", place(name));
}

void File::attribute(const std::string& name, const char* key, const std::string& text) {
  // One byte at least: HDF5 has no empty strings of fixed length.
  add_attribute(name, key, text_type(text.size(), place(name)), {}, text.c_str());
}

void File::attribute(const std::string& name, const char* key, int value) {
  add_attribute(name, key, H5T_NATIVE_INT, {}, &value);
}

void File::attribute(const std::string& name, const char* key, std::span<const int> values) {
  add_attribute(name, key, H5T_NATIVE_INT, std::array{hsize_t{values.size()}}, values.data());
}

void File::attribute(const std::string& name, const char* key, std::span<const std::string> texts) {
  std::size_t width = 1;
  for (const auto& text : texts) width = std::max(width, text.size());
  std::string padded;
  for (const auto& text : texts) padded += text + std::string(width - text.size(), '\0');
  add_attribute(name, key, text_type(width, place(name)), std::array{hsize_t{texts.size()}},
                padded.data());
}

void File::link(const std::string& object, const std::string& name) {
  check(H5Lcreate_hard(file_, object.c_str(), file_, name.c_str(), with_parents(place(name)),
                       H5P_DEFAULT),
        "H5Lcreate_hard", place(name));
}

void File::link_outside(const std::string& file, const std::string& object,
                        const std::string& name) {
  check(H5Lcreate_external(file.c_str(), object.c_str(), file_, name.c_str(),
                           with_parents(place(name)), H5P_DEFAULT),
        "H5Lcreate_external", place(name));
}

void File::write_text(const std::string& name, const std::string& text) {
  Handle type = text_type(text.size(), place(name));
  Handle space = make(H5Screate(H5S_SCALAR), H5Sclose, "H5Screate", place(name));
  Handle set = make(H5Dcreate2(file_, name.c_str(), type, space, with_parents(place(name)),
                               H5P_DEFAULT, H5P_DEFAULT),
                    H5Dclose, "H5Dcreate2", place(name));
  if (leader_)
    check(H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, text.c_str()), "H5Dwrite",
          place(name));
  set.finish("H5Dclose", place(name));
}

std::string File::read_text(const std::string& name) const {
  Handle set = make(H5Dopen2(file_, name.c_str(), H5P_DEFAULT), H5Dclose, "H5Dopen2", place(name));
  Handle type = make(H5Dget_type(set), H5Tclose, "H5Dget_type", place(name));
  Handle space = make(H5Dget_space(set), H5Sclose, "H5Dget_space", place(name));
  require(H5Tget_class(type) == H5T_STRING && H5Tis_variable_str(type) == 0 &&
              H5Sget_simple_extent_npoints(space) == 1,
          "'{}' is not one text of fixed length", place(name));
  check_stored(set, H5Tget_size(type), place(name));
  std::string text(H5Tget_size(type), '\0');
  check(H5Dread(set, type, H5S_ALL, H5S_ALL, transfer_, text.data()), "H5Dread", place(name));
  text.resize(std::min(text.find('\0'), text.size()));
  return text;
}

Handle File::create_dataset(const std::string& name, hid_t type, hsize_t width, hsize_t rows,
                            bool as_frame) {
  std::vector<hsize_t> dimensions;
  if (as_frame) dimensions.push_back(1);
  dimensions.push_back(rows);
  if (width > 1) dimensions.push_back(width);
  Handle space =
      make(H5Screate_simple(static_cast<int>(dimensions.size()), dimensions.data(), nullptr),
           H5Sclose, "H5Screate_simple", place(name));
  return make(H5Dcreate2(file_, name.c_str(), type, space, with_parents(place(name)), H5P_DEFAULT,
                         H5P_DEFAULT),
              H5Dclose, "H5Dcreate2", place(name));
}

void File::write_rows(const std::string& name, hid_t plain, hsize_t width, const void* values,
                      const Rows& rows, bool as_frame, const Names& names) {
  const Handle type = type_of(plain, names, place(name));
  Handle set = create_dataset(name, type, width, rows.total, as_frame);
  if (rows.total > 0) {
    Handle space = make(H5Dget_space(set), H5Sclose, "H5Dget_space", place(name));
    Handle memory = memory_space(rows, width, place(name));
    select(memory, space, rows, as_frame, width, place(name));
    check(H5Dwrite(set, type, memory, space, transfer_, values), "H5Dwrite", place(name));
  }
  set.finish("H5Dclose", place(name));
}

void File::write_same(const std::string& name, hid_t type, hsize_t width, const void* values,
                      hsize_t count) {
  Handle set = create_dataset(name, type, width, count, false);
  if (leader_ && count > 0)
    check(H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values), "H5Dwrite", place(name));
  set.finish("H5Dclose", place(name));
}

void File::write_view_raw(const std::string& name, hid_t plain, hsize_t width,
                          std::span<const Source> sources, hsize_t total, bool as_frames,
                          const Names& names) {
  const Handle type = type_of(plain, names, place(name));
  std::vector<hsize_t> dimensions;
  if (as_frames) dimensions.push_back(sources.size());
  dimensions.push_back(total);
  if (width > 1) dimensions.push_back(width);
  const auto rank = static_cast<int>(dimensions.size());
  Handle space =
      make(H5Screate_simple(rank, dimensions.data(), nullptr), H5Sclose, "H5Screate_simple", name);
  Handle list = make(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, "H5Pcreate", name);
  const double no_number = std::numeric_limits<double>::quiet_NaN();
  const std::int64_t nobody = -1;  // the bits of -1 in shorter integers too
  const void* absent =
      H5Tget_class(type) == H5T_FLOAT ? static_cast<const void*>(&no_number) : &nobody;
  check(H5Pset_fill_value(list, type, absent), "H5Pset_fill_value", name);
  for (std::size_t k = 0; k < sources.size(); ++k) {
    std::vector<hsize_t> start(rank, 0), count = dimensions;
    if (as_frames) {
      start[0] = k;
      count[0] = 1;
    }
    count[as_frames] = sources[k].rows;
    check(H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr),
          "H5Sselect_hyperslab", name);
    Handle source =
        make(H5Screate_simple(rank, count.data(), nullptr), H5Sclose, "H5Screate_simple", name);
    check(H5Pset_virtual(list, space, sources[k].file.c_str(), name.c_str(), source),
          "H5Pset_virtual", place(name));
  }
  make(H5Dcreate2(file_, name.c_str(), type, space, with_parents(place(name)), list, H5P_DEFAULT),
       H5Dclose, "H5Dcreate2", place(name))
      .finish("H5Dclose", place(name));
}

bool File::exists(const std::string& name) const {
  // HDF5 asks for every link on the way, the root apart.
  for (std::size_t at = name.find('/', 1);; at = name.find('/', at + 1)) {
    if (check(H5Lexists(file_, name.substr(0, at).c_str(), H5P_DEFAULT), "H5Lexists",
              place(name)) == 0)
      return false;
    if (at == std::string::npos) return true;
  }
}

hsize_t File::total_rows(const std::string& name) const {
  Handle set = make(H5Dopen2(file_, name.c_str(), H5P_DEFAULT), H5Dclose, "H5Dopen2", place(name));
  Handle space = make(H5Dget_space(set), H5Sclose, "H5Dget_space", place(name));
  hsize_t dimensions[H5S_MAX_RANK] = {0};
  check(H5Sget_simple_extent_dims(space, dimensions, nullptr), "H5Sget_simple_extent_dims",
        place(name));
  return dimensions[0];
}

hsize_t File::check_values(const std::string& name, hid_t type, hsize_t width,
                           const std::optional<Rows>& rows) const {
  Handle set = make(H5Dopen2(file_, name.c_str(), H5P_DEFAULT), H5Dclose, "H5Dopen2", place(name));
  Handle space = make(H5Dget_space(set), H5Sclose, "H5Dget_space", place(name));
  Handle stored = make(H5Dget_type(set), H5Tclose, "H5Dget_type", place(name));
  const H5T_class_t kind = H5Tget_class(stored);
  const bool whole = kind == H5T_INTEGER || kind == H5T_ENUM;
  require(whole || (kind == H5T_FLOAT && H5Tget_class(type) == H5T_FLOAT), "'{}' does not hold {}",
          place(name), H5Tget_class(type) == H5T_FLOAT ? "numbers" : "whole numbers");
  const auto count = static_cast<hsize_t>(
      check(H5Sget_simple_extent_npoints(space), "H5Sget_simple_extent_npoints", place(name)));
  require(!rows || count == rows->total * width, "'{}' holds {} values, not {} rows of {}",
          place(name), count, rows ? rows->total : 0, width);
  const int rank = H5Sget_simple_extent_ndims(space);
  std::array<hsize_t, H5S_MAX_RANK> dimensions{};
  check(H5Sget_simple_extent_dims(space, dimensions.data(), nullptr), "H5Sget_simple_extent_dims",
        place(name));
  require(width == 1 || (rank > 0 && dimensions[rank - 1] == width),
          "'{}' does not hold rows of {} values", place(name), width);
  check_stored(set, count * H5Tget_size(stored), place(name));
  return count;
}

void File::read_raw(const std::string& name, hid_t type, hsize_t width, void* values,
                    const std::optional<Rows>& rows) const {
  Handle set = make(H5Dopen2(file_, name.c_str(), H5P_DEFAULT), H5Dclose, "H5Dopen2", place(name));
  Handle space = make(H5Dget_space(set), H5Sclose, "H5Dget_space", place(name));
  Handle memory;
  if (rows) {
    memory = memory_space(*rows, width, place(name));
    select(memory, space, *rows, false, width, place(name));
  }
  check(H5Dread(set, type, rows ? hid_t(memory) : H5S_ALL, rows ? hid_t(space) : H5S_ALL, transfer_,
                values),
        "H5Dread", place(name));
}

void write_h5md(File& file) {
  file.group("/h5md/author");
  file.group("/h5md/creator");
  file.group("/h5md/modules/units");
  file.attribute("/h5md", "version", std::array{1, 1});
  file.attribute("/h5md/modules/units", "version", std::array{1, 0});
  file.attribute("/h5md/modules/units", "system", "SI");
  file.attribute("/h5md/author", "name", "unknown");
  file.attribute("/h5md/creator", "name", "spall");
  file.attribute("/h5md/creator", "version", SPALL_VERSION);
}

}  // namespace spall::h5
