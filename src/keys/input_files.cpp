// Rank 0 reads, the others receive.
// SPDX-License-Identifier: BSD-3-Clause
#include "keys/input_files.hpp"

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <utility>

#include "base/first_rank.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

void check_is_file(const std::string& path) {
  require(!std::filesystem::is_directory(path), "'{}' is a folder, not a file", path);
  require(std::filesystem::exists(path), "there is no file '{}'", path);
  require(std::filesystem::is_regular_file(path), "'{}' is a device or a pipe, not a file", path);
}

std::string read_text(const std::string& path) {
  check_is_file(path);
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  require(file.good(), "{}: cannot be opened: {}", path, std::strerror(errno));
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace

bool InputFiles::exists(const std::string& path) const {
  std::error_code unreadable;  // such as a name that is too long: there is none
  const bool here =
      (!comm_ || comm_->rank == 0) && std::filesystem::is_regular_file(path, unreadable);
  return comm_ ? comm_->any(here) : here;
}

void InputFiles::require_file(const std::string& path) const {
  if (!comm_) return check_is_file(path);
  on_first_rank(*comm_, [&] { check_is_file(path); });
}

std::string InputFiles::text(const std::string& path) const {
  if (!comm_) return read_text(path);
  std::string text;
  on_first_rank(*comm_, [&] { text = read_text(path); });
  return text_of_first_rank(*comm_, std::move(text));
}

std::vector<double> InputFiles::numbers(const std::function<std::vector<double>()>& read) const {
  if (!comm_) return read();
  std::vector<double> values;
  on_first_rank(*comm_, [&] { values = read(); });
  const auto count = comm_->sum(static_cast<std::int64_t>(values.size()));  // the others have none
  values.resize(static_cast<std::size_t>(count));
  comm_->broadcast(values, 0);
  return values;
}

}  // namespace spall
