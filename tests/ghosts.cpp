// The ghost exchange: every ghost value is its original's.
// SPDX-License-Identifier: BSD-3-Clause
#include "domain/ghosts.hpp"

#include "testing.hpp"

namespace spall {
namespace {

/// Every rank owns `rank + 2` rows and holds ghosts of every row of every other rank.
struct Everything {
  Comm comm = testing_world();
  Index owned = comm.rank + 2;
  std::vector<Origin> origins = [this] {
    std::vector<Origin> all;
    for (int r = 0; r < comm.size; ++r)
      for (Index row = 0; r != comm.rank && row < r + 2; ++row) all.push_back({r, row});
    return all;
  }();
  Ghosts ghosts{comm, owned, origins};
  Index size() const { return owned + static_cast<Index>(origins.size()); }
};

TEST(Ghosts, gather_gives_every_ghost_its_original) {
  Everything all;
  for (int width : {1, 3, 8}) {
    std::vector<double> rows(all.size() * width, std::nan(""));
    for (Index b = 0; b < all.owned; ++b)
      for (int k = 0; k < width; ++k) rows[b * width + k] = 1000 * all.comm.rank + 10 * b + k;
    all.ghosts.gather(rows.data(), width);
    for (std::size_t g = 0; g < all.origins.size(); ++g)
      for (int k = 0; k < width; ++k)
        EXPECT_EQ(rows[(all.owned + g) * width + k],
                  1000 * all.origins[g].rank + 10 * all.origins[g].row + k);
  }
}

TEST(Ghosts, scatter_add_sums_all_copies_onto_the_original) {
  Everything all;
  std::vector<double> rows(all.size() * 3, 1.0);
  all.ghosts.scatter_add(rows.data(), 3);
  for (Index b = 0; b < all.owned; ++b) EXPECT_EQ(rows[b * 3 + 2], all.comm.size);
}

TEST(Ghosts, holders_are_all_other_ranks) {
  Everything all;
  const auto holders = all.ghosts.holders();
  for (Index b = 0; b < all.owned; ++b)
    EXPECT_EQ(holders.start[b + 1] - holders.start[b], all.comm.size - 1);
}

}  // namespace
}  // namespace spall
