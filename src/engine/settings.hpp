// What a case tells its engines, each in a type of its own.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <any>
#include <map>
#include <typeindex>

namespace spall {

class EngineSettings {
 public:
  template <class Settings>
  void set(Settings settings) {
    of_type_[typeid(Settings)] = std::move(settings);
  }
  /// Null where the case says nothing of it.
  template <class Settings>
  const Settings* find() const {
    const auto found = of_type_.find(typeid(Settings));
    return found == of_type_.end() ? nullptr : std::any_cast<Settings>(&found->second);
  }
  template <class Settings>
  Settings* find() {
    const auto found = of_type_.find(typeid(Settings));
    return found == of_type_.end() ? nullptr : std::any_cast<Settings>(&found->second);
  }
  /// These, or defaults. They last as long as this does.
  template <class Settings>
  const Settings& get() const {
    static const Settings defaults{};
    const Settings* found = find<Settings>();
    return found ? *found : defaults;
  }

 private:
  std::map<std::type_index, std::any> of_type_;
};

}  // namespace spall
