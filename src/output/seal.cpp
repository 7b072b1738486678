// Words are summed with their places mixed in: a sum is the same for any number of ranks, and one
// word that differs always changes it.
// SPDX-License-Identifier: BSD-3-Clause
#include "output/seal.hpp"

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <vector>

#include "base/first_rank.hpp"
#include "base/hash.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

constexpr std::size_t word_size = sizeof(std::uint64_t);

/// The seal that the bytes of a file ask for; Error on all ranks where one cannot read its part.
/// Collective.
std::string wanted_seal(const Comm& comm, const std::string& path) {
  errno = 0;
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  const auto require_all = [&](bool own) {
    const int reason = errno;
    const bool failed = comm.any(!own);
    require(!failed, "cannot read '{}': {}", path,
            own ? "another rank cannot" : std::strerror(reason));
  };
  require_all(file.good());
  const auto size = static_cast<std::int64_t>(file.tellg());
  const std::int64_t behind = std::max<std::int64_t>(size - std::int64_t{seal_size}, 0);
  const std::int64_t words = (behind + word_size - 1) / word_size;
  const std::int64_t end = part_begin(words, comm.rank + 1, comm.size);
  std::int64_t word = part_begin(words, comm.rank, comm.size);
  file.seekg(static_cast<std::streamoff>(seal_size + word * word_size));
  constexpr std::int64_t words_at_once = 1 << 17;
  std::vector<std::uint64_t> block;
  std::uint64_t sum = 0;
  bool whole = true;
  while (whole && word < end) {
    block.assign(std::min(words_at_once, end - word), 0);  // zeros fill up the last word
    const auto bytes =
        std::min<std::int64_t>(std::ssize(block) * word_size, behind - word * word_size);
    errno = 0;
    file.read(reinterpret_cast<char*>(block.data()), bytes);
    whole = file.gcount() == bytes;
    for (std::uint64_t bits : block) sum += mix(mix(++word) ^ bits);
  }
  require_all(whole);
  const auto all = std::bit_cast<std::uint64_t>(comm.sum(std::bit_cast<std::int64_t>(sum)));
  std::string text = fmt::format("Spall: {} bytes, checksum {:016x}\n", size, all);
  text.resize(seal_size, '\0');
  return text;
}

std::string first_bytes(const std::string& path, std::size_t count) {
  std::string bytes(count, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(bytes.data(), static_cast<std::streamsize>(count));
  bytes.resize(file.gcount());
  return bytes;
}

}  // namespace

void seal(const Comm& comm, const std::string& path) {
  const std::string text = wanted_seal(comm, path);
  on_first_rank(comm, [&] {
    errno = 0;
    std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
    file.write(text.data(), std::ssize(text)).flush();
    require(file.good(), "cannot write '{}': {}", path, std::strerror(errno));
  });
}

void check_seal(const Comm& comm, const std::string& path) {
  const std::string found = first_bytes(path, seal_size), wanted = wanted_seal(comm, path);
  // A shared file system may show ranks different files: all throw, or none.
  require(!comm.any(!found.starts_with(wanted.substr(0, wanted.find(' ')))),
          "it has no seal: another program or an older Spall wrote it");
  require(!comm.any(found != wanted),
          "its bytes are not those that were written: they give the seal '{}'",
          wanted.substr(0, wanted.find('\n')));
}

bool begins_as_hdf5(const std::string& path) {
  return first_bytes(path, 8) == "\x89HDF\r\n\x1a\n";
}

}  // namespace spall
