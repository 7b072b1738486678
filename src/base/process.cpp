// Linux tells memory in pages, and words with a zero behind each.
// SPDX-License-Identifier: BSD-3-Clause
#include "base/process.hpp"

#include <unistd.h>

#include <fstream>

namespace spall {
namespace {

/// In quotes where a shell would read signs in it.
std::string in_quotes(const std::string& word) {
  constexpr const char* plain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=./:,@%^";
  if (!word.empty() && word.find_first_not_of(plain) == word.npos) return word;
  std::string text;
  for (char c : word) {
    text += c;
    if (c == '\'') text += "\\''";
  }
  return "'" + text + "'";
}

}  // namespace

double resident_bytes() {
  std::ifstream file("/proc/self/statm");
  double all = 0, resident = 0;
  file >> all >> resident;
  return file ? resident * static_cast<double>(sysconf(_SC_PAGESIZE)) : 0;
}

std::string host_name() {
  char name[256] = "";
  gethostname(name, sizeof name - 1);
  return name;
}

std::string command_line() {
  std::ifstream file("/proc/self/cmdline", std::ios::binary);
  std::string line;
  for (std::string word; std::getline(file, word, '\0');) {
    if (!line.empty()) line += ' ';
    line += in_quotes(word);
  }
  return line;
}

}  // namespace spall
