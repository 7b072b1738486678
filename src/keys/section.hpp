// One table of a case file, read strictly: what is asked for is what may be there.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <toml++/toml.h>

#include <array>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "base/choice.hpp"
#include "keys/units.hpp"
#include "spall/types.hpp"

namespace spall {

/// What a number must be.
struct Quantity {
  Dimension dimension;
  double low = -infinity, high = infinity;
  bool low_allowed = true;
};
constexpr Quantity any(Dimension d) {
  return {d};
}
constexpr Quantity positive(Dimension d) {
  return {d, 0, infinity, false};
}
constexpr Quantity not_negative(Dimension d) {
  return {d, 0};
}
inline constexpr Quantity fraction{dimension::number, 0, 1};

/// Reads keys into fields: `need` for keys that must be there, `take` for those that may be left
/// out, whose field then keeps its default. Without a table nothing is read: the same calls write
/// the reference of all keys instead. Keys that are not in it cannot be read.
class Section {
 public:
  using Reader = std::function<void(Section&)>;

  /// All keys that a reader asks for.
  struct Reference {
    std::string text;            ///< a line a key, with unit, default and meaning
    std::set<std::string> keys;  ///< "groups.volume.radius"
  };
  static Reference reference(const Reader& read);

  /// The table of `file`; `read` asks for its keys. Throws Error at the first key that is
  /// unknown, missing or wrong, and std::logic_error where `read` asks for a key that `listed`
  /// lacks: one behind a condition that is not passed to `reads`.
  static void read_all(const toml::table& table, const std::string& file, const Reader& read,
                       const Reference& listed);

  template <class... Into>
  void need(std::string_view key, std::string_view meaning, Into&&... into) {
    read({key, meaning, true}, into...);
  }
  template <class... Into>
  void take(std::string_view key, std::string_view meaning, Into&&... into) {
    read({key, meaning, false}, into...);
  }
  /// `radius` or `diameter`, one of them.
  void radius(std::string_view meaning, double& radius);
  /// A table below this one; false where it is left out.
  bool table(std::string_view key, std::string_view meaning, const Reader& read);
  /// An array of tables: `read` is called for each.
  void tables(std::string_view key, std::string_view meaning, const Reader& read);

  /// A table of tables: `read` is called for each with its name.
  void named_tables(std::string_view key, std::string_view meaning,
                    const std::function<void(Section&, const std::string&)>& read);

  bool has(std::string_view key) const { return table_ && table_->contains(key); }
  /// True also while the reference is written: then every key is asked for.
  bool reads(bool condition) const { return reference_ || condition; }
  /// Throws Error, which says `what` is wrong with `key`, unless `ok`.
  void check(std::string_view key, bool ok, std::string_view what) const;
  /// Where this table or a key of it is in the file: "cases/x.toml:12:5: groups.cloud".
  std::string place(std::string_view key = "") const;

 private:
  struct Key {
    std::string_view name, meaning;
    bool required;
  };

  /// Where a table is: for people, with the names of elements, and among all keys.
  struct Path {
    std::string of_place;  ///< "phases.impact"
    std::string of_keys;   ///< "phases"
  };

  Section(const toml::table* table, const std::string& file, Path path, const Reference* listed,
          Reference* reference)
      : table_(table),
        file_(file),
        path_(std::move(path)),
        listed_(listed),
        reference_(reference) {}

  Path below(std::string_view key) const { return {path_of(key), key_of(key)}; }
  /// Reads the table `node` at `path`, or writes its keys into the reference.
  bool read_below(std::string_view key, const toml::node* node, Path path, const Reader& read);

  void read(const Key& key, double& value, const Quantity& quantity);
  void read(const Key& key, std::optional<double>& value, const Quantity& quantity);
  void read(const Key& key, Vec3& value, const Quantity& quantity);
  void read(const Key& key, std::vector<double>& values, const Quantity& quantity);
  void read(const Key& key, std::vector<Vec3>& values, const Quantity& quantity);
  void read(const Key& key, std::int64_t& value, std::int64_t low);
  void read(const Key& key, std::vector<std::string>& values);
  void read(const Key& key, std::string& value);
  void read(const Key& key, std::array<std::string, 2>& names);
  void read(const Key& key, bool& value);
  template <class Enum, std::size_t n>
  void read(const Key& key, Enum& value, const Choice<Enum> (&choices)[n]) {
    std::vector<std::string_view> names;
    std::size_t chosen = 0;
    for (std::size_t c = 0; c < n; ++c) {
      names.push_back(choices[c].name);
      if (choices[c].value == value) chosen = c;
    }
    value = choices[choose(key, names, chosen)].value;
  }

  void read(const Key& key, std::size_t& chosen, const std::vector<std::string_view>& names) {
    chosen = choose(key, names, chosen);
  }

  /// The node of `key`, written down as known; null where it is left out.
  const toml::node* find(const Key& key, const std::string& kind, const std::string& by_default);
  double number(std::string_view key, const toml::node& node, const Quantity& quantity) const;
  Vec3 vector(std::string_view key, const toml::node& node, const Quantity& quantity) const;
  std::size_t choose(const Key& key, const std::vector<std::string_view>& names,
                     std::size_t by_default);
  [[noreturn]] void fail(std::string_view key, std::string_view what) const;
  std::string path_of(std::string_view key) const;
  std::string key_of(std::string_view key) const;
  std::string place_of(const toml::source_region& source) const;
  void finish() const;

  const toml::table* table_;
  const std::string& file_;
  Path path_;
  const Reference* listed_;
  Reference* reference_;  ///< being written; null while a table is read
  std::vector<std::string> known_, missing_;
};

}  // namespace spall
