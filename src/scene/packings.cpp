// One line a packing; each is defined where its spheres are placed.
// SPDX-License-Identifier: BSD-3-Clause
#include <array>

#include "scene/packing.hpp"

namespace spall {

extern const PackingType random_packing, simple_cubic_packing, fcc_packing, hcp_packing;
extern const PackingType graded_packing;
extern const PackingType file_packing;

std::span<const PackingType* const> all_packings() {
  static constexpr std::array packings{
      &single_packing, &random_packing, &simple_cubic_packing, &fcc_packing,
      &hcp_packing,    &graded_packing, &file_packing,
  };
  return packings;
}

}  // namespace spall
