// HDF5 files told line by line, so that broken ones can be written down, and made up at random.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

#include "../src/output/h5.hpp"
#include "output/seal.hpp"
#include "spall/error.hpp"

namespace spall {

/// \n and \x00 as the bytes that they stand for.
inline std::string bytes_of(const std::string& text) {
  std::string bytes;
  for (std::size_t at = 0; at < text.size(); ++at) {
    if (text.compare(at, 2, "\\n") == 0) {
      bytes += '\n';
      at += 1;
    } else if (text.compare(at, 2, "\\x") == 0) {
      bytes += static_cast<char>(std::stoi(text.substr(at + 2, 2), nullptr, 16));
      at += 3;
    } else {
      bytes += text[at];
    }
  }
  return bytes;
}

/// Of one dataset; what lacks in `values` is zeros.
inline void write_values(const std::string& name, const std::string& type, hid_t set,
                         const std::string& values) {
  const h5::Handle stored(H5Dget_type(set), H5Tclose), space(H5Dget_space(set), H5Sclose);
  const auto count = static_cast<std::size_t>(H5Sget_simple_extent_npoints(space));
  constexpr std::size_t most = 1'000'000;
  require(count <= most && H5Tget_size(stored) <= most, "{} is too long to be told", name);
  if (count == 0) return;
  std::istringstream in(values);
  std::vector<std::int64_t> whole;
  std::vector<double> real;
  for (std::string word; type != "text" && in >> word;)
    type == "double" ? real.push_back(std::stod(word)) : whole.push_back(std::stoll(word));
  std::string text = bytes_of(values);
  text.resize(H5Tget_size(stored));
  whole.resize(count);
  real.resize(count);
  const auto write = [&](hid_t memory, const void* data) {
    h5::check(H5Dwrite(set, memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, data), "H5Dwrite", name);
  };
  if (type == "text")
    write(stored, text.data());
  else if (type == "double")
    write(H5T_NATIVE_DOUBLE, real.data());
  else
    write(H5T_NATIVE_INT64, whole.data());
}

/// A dataset a line: "/NAME TYPE SHAPE = VALUES", with TYPE int, long, double or text, whose SHAPE
/// is its length; "claimed" in place of values: none are stored. "sealed" stands before all.
inline void write_hdf5(const std::string& path, const std::string& content) {
  const bool sealed = content.starts_with("sealed\n");
  h5::File file = h5::File::create(path, sealed ? seal_size : 0);
  std::istringstream lines(content);
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line == "sealed") continue;
    std::istringstream words(line);
    std::string name, type, shape;
    words >> name >> type >> shape;
    std::vector<hsize_t> size;
    std::istringstream numbers(shape);
    for (std::string number; std::getline(numbers, number, 'x');)
      size.push_back(std::stoull(number));
    h5::Handle stored(H5Tcopy(type == "text"   ? H5T_C_S1
                              : type == "int"  ? H5T_NATIVE_INT32
                              : type == "long" ? H5T_NATIVE_INT64
                                               : H5T_NATIVE_DOUBLE),
                      H5Tclose);
    if (type == "text") {
      H5Tset_size(stored, size.at(0));
      size.clear();
    }
    const h5::Handle space(H5Screate_simple(static_cast<int>(size.size()), size.data(), nullptr),
                           H5Sclose);
    const h5::Handle parents(H5Pcreate(H5P_LINK_CREATE), H5Pclose);
    H5Pset_create_intermediate_group(parents, 1);
    const h5::Handle set(h5::check(H5Dcreate2(file.id(), name.c_str(), stored, space, parents,
                                              H5P_DEFAULT, H5P_DEFAULT),
                                   "H5Dcreate2", name),
                         H5Dclose);
    const std::size_t equals = line.find(" = ");
    if (equals != line.npos) write_values(name, type, set, line.substr(equals + 3));
  }
  file.close();
  if (sealed) seal(Comm(MPI_COMM_SELF), path);
}

}  // namespace spall
