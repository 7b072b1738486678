// The CSV is the record; the HDF5 file is made from it, so it never disagrees.
// SPDX-License-Identifier: BSD-3-Clause
#include "output/series.hpp"

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <optional>

#include "base/first_rank.hpp"
#include "base/hash.hpp"
#include "output/files.hpp"
#include "output/h5.hpp"
#include "spall/error.hpp"

namespace spall {

namespace {

/// A line of the file: the step, the time and the values; none where it is not whole.
struct Row {
  std::int64_t step = 0;
  std::vector<double> numbers;
};
std::optional<Row> parse_row(const std::string& line, std::size_t columns) {
  Row row;
  char* at = nullptr;
  row.step = std::strtoll(line.c_str(), &at, 10);
  if (at == line.c_str()) return std::nullopt;
  while (*at == ',') {
    const char* begin = at + 1;
    row.numbers.push_back(std::strtod(begin, &at));
    if (at == begin) return std::nullopt;
  }
  const bool whole = at == line.c_str() + line.size() && row.numbers.size() == columns + 1;
  return whole ? std::optional(std::move(row)) : std::nullopt;
}

}  // namespace

Series::Series(const Comm& comm, const std::string& folder, std::vector<Column> columns,
               std::int64_t resume_step, const SeriesRows& written)
    : path_(folder + "/series.csv"), columns_(std::move(columns)), writes_(comm.rank == 0) {
  make_folder(comm, folder);
  std::string heading = "step,time";
  for (const auto& column : columns_) heading += "," + column.name;
  on_first_rank(comm, [&] {
    std::string text = heading + "\n";
    if (resume_step >= 0 && std::filesystem::exists(path_)) {
      const auto lines = complete_lines(read_whole(path_));
      require(!lines.empty() && lines[0] == heading,
              "'{}' has other columns than this run: move it away to resume", path_);
      for (std::size_t k = 1; k < lines.size(); ++k) {
        const auto row = parse_row(lines[k], columns_.size());
        require(row.has_value(), "'{}': line {} is not whole: move the file away to resume", path_,
                k + 1);
        if (row->step > resume_step) continue;
        text += lines[k] + "\n";
        count(lines[k]);
      }
      require(rows_.count == written.count,
              "'{}' has {} rows up to step {}, but {} were written: move the file away to resume",
              path_, rows_.count, resume_step, written.count);
      require(rows_.checksum == written.checksum,
              "'{}': its rows up to step {} are not those that were written: move the file away to "
              "resume",
              path_, resume_step);
    }
    write_whole(path_, text);
    file_.open(path_, std::ios::app);
    require(file_.good(), "cannot write '{}': {}", path_, std::strerror(errno));
  });
  rows_.count = comm.sum(rows_.count);  // rank 0's
}

void Series::count(const std::string& line) {
  ++rows_.count;
  auto sum = static_cast<std::uint64_t>(rows_.checksum);
  for (const char c : line) sum = mix(sum << 8 | static_cast<unsigned char>(c)) >> 12;
  rows_.checksum = static_cast<std::int64_t>(sum);
}

void Series::append(std::int64_t step, double time, std::span<const double> values) {
  require(values.size() == columns_.size(), "a row of {} values for {} columns", values.size(),
          columns_.size());
  if (!writes_) {
    ++rows_.count;
    return;
  }
  std::string line = fmt::format("{},{}", step, time);
  for (double value : values) line += fmt::format(",{}", value);
  count(line);
  errno = 0;
  file_ << line << '\n' << std::flush;
  const int reason = errno;
  require(file_.good(), "cannot write '{}': {}", path_, std::strerror(reason));
}

void Series::write_hdf5() const {
  if (!writes_) return;
  const auto lines = complete_lines(read_whole(path_));
  std::vector<std::int64_t> steps;
  std::vector<double> times;
  std::vector<std::vector<double>> values(columns_.size());
  for (std::size_t k = 1; k < lines.size(); ++k) {
    const auto row = parse_row(lines[k], columns_.size());
    require(row.has_value(), "'{}': line {} is not whole", path_, k + 1);
    steps.push_back(row->step);
    times.push_back(row->numbers[0]);
    for (std::size_t c = 0; c < values.size(); ++c) values[c].push_back(row->numbers[c + 1]);
  }
  const std::string path = std::filesystem::path(path_).replace_extension(".h5").string();
  auto file = h5::File::create(unfinished(path));
  h5::write_h5md(file);
  file.write<std::int64_t>("/series/step", steps);
  file.write<double>("/series/time", times);
  file.attribute("/series/time", "unit", "s");
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    const std::string group = "/observables/" + columns_[c].name;
    file.write<double>(group + "/value", values[c]);
    if (!columns_[c].unit.empty()) file.attribute(group + "/value", "unit", columns_[c].unit);
    file.link("/series/step", group + "/step");
    file.link("/series/time", group + "/time");
  }
  file.close();
  put_in_place(path);
}

}  // namespace spall
