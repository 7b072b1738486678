// One list of rows, two ways to write it.
// SPDX-License-Identifier: BSD-3-Clause
#include "output/results.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>

#include "base/first_rank.hpp"
#include "keys/toml_text.hpp"
#include "output/files.hpp"
#include "spall/error.hpp"

namespace spall {

namespace {

template <class Number>
std::string list(const std::vector<double>& values, Number&& number) {
  std::string text = "[";
  for (std::size_t k = 0; k < values.size(); ++k) text += (k ? ", " : "") + number(values[k]);
  return text + "]";
}

struct ToToml {
  std::string operator()(double value) const { return toml_number(value); }
  std::string operator()(std::int64_t value) const { return fmt::format("{}", value); }
  std::string operator()(bool value) const { return value ? "true" : "false"; }
  std::string operator()(const std::string& value) const { return toml_string(value); }
  std::string operator()(const std::vector<double>& values) const {
    return list(values, toml_number);
  }
};

struct ToText {
  std::string operator()(double value) const { return fmt::format("{:.6g}", value); }
  std::string operator()(std::int64_t value) const { return fmt::format("{}", value); }
  std::string operator()(bool value) const { return value ? "yes" : "no"; }
  std::string operator()(const std::string& value) const { return value; }
  std::string operator()(const std::vector<double>& values) const {
    return list(values, [this](double value) { return (*this)(value); });
  }
};

}  // namespace

void ResultTable::add(const std::string& section, const std::string& key, Value value,
                      const std::string& unit, const std::string& note) {
  auto s = std::find_if(sections_.begin(), sections_.end(),
                        [&](const Section& one) { return one.name == section; });
  if (s == sections_.end()) s = sections_.insert(s, {section, {}});
  const auto r =
      std::find_if(s->rows.begin(), s->rows.end(), [&](const Row& one) { return one.key == key; });
  Row row{key, std::move(value), unit, note};
  if (r == s->rows.end())
    s->rows.push_back(std::move(row));
  else
    *r = std::move(row);
}

std::string ResultTable::text() const {
  std::size_t keys = 0, values = 0, units = 0;
  for (const Section& section : sections_)
    for (const Row& row : section.rows) {
      keys = std::max(keys, row.key.size());
      units = std::max(units, row.unit.size());
      // A long list or text may stand out instead of widening every row.
      values = std::max(values, std::min<std::size_t>(std::visit(ToText{}, row.value).size(), 14));
    }
  std::string text;
  for (const Section& section : sections_) {
    text += section.name + "\n";
    for (const Row& row : section.rows) {
      std::string line =
          fmt::format("  {:<{}}  {:>{}}  {:<{}}  {}", row.key, keys,
                      std::visit(ToText{}, row.value), values, row.unit, units, row.note);
      line.erase(line.find_last_not_of(' ') + 1);
      text += line + "\n";
    }
  }
  return text;
}

std::string ResultTable::toml() const {
  std::string text;
  for (const Section& section : sections_) {
    text += fmt::format("{}[{}]\n", text.empty() ? "" : "\n", section.name);
    for (const Row& row : section.rows) {
      text += fmt::format("{} = {}", row.key, std::visit(ToToml{}, row.value));
      const bool both = !row.unit.empty() && !row.note.empty();
      if (!row.unit.empty() || !row.note.empty())
        text += fmt::format("  # {}{}{}", row.unit, both ? "; " : "", row.note);
      text += "\n";
    }
  }
  return text;
}

void write_results(const Comm& comm, const std::string& folder, ResultTable table,
                   const Provenance& provenance) {
  for (const auto& [key, value] : provenance)
    std::visit([&, &name = key](const auto& v) { table.add("provenance", name, v); }, value);
  make_folder(comm, folder);
  on_first_rank(comm, [&] { write_whole(folder + "/results.toml", table.toml()); });
}

namespace {

/// Beside the results; without a text there is no such file.
void keep(const Comm& comm, const std::string& path, const std::function<std::string()>& text_of) {
  make_folder(comm, std::filesystem::path(path).parent_path());
  on_first_rank(comm, [&] {
    const std::string text = text_of();
    if (text.empty())
      std::filesystem::remove(path);
    else
      write_whole(path, text);
  });
}

}  // namespace

void keep_reference(const Comm& comm, const std::string& folder, const std::string& file) {
  keep(comm, folder + "/reference.toml", [&] { return file.empty() ? "" : read_whole(file); });
}

void keep_case(const Comm& comm, const std::string& folder, const std::string& resolved) {
  keep(comm, folder + "/resolved_case.toml", [&] { return resolved; });
}

}  // namespace spall
