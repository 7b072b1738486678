// A case as one text with all changes in it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <toml++/toml.h>

#include <string>

#include "scene/case.hpp"

namespace spall {

/// TOML that gives `scene` again, from whichever folder: `root` is what it was read from, after all
/// changes. Files of materials are in it, other files are named by their whole paths, and the
/// reference is the copy that runs keep beside their results.
std::string resolved_text(toml::table root, const Case& scene);

}  // namespace spall
