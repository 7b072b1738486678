// The ghost exchange: every ghost value is its original's.
// SPDX-License-Identifier: BSD-3-Clause
#include "domain/ghosts.hpp"

#include "base/traffic.hpp"
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

TEST(Ghosts, gather_of_several_fields_is_one_message_to_each_rank) {
  Everything all;
  const auto value = [](int rank, Index row, int k) { return 1000.0 * rank + 10 * row + k; };
  std::vector<double> one(all.size(), std::nan("")), three(3 * all.size(), std::nan(""));
  for (Index b = 0; b < all.owned; ++b) {
    one[b] = value(all.comm.rank, b, 0);
    for (int k = 0; k < 3; ++k) three[3 * b + k] = value(all.comm.rank, b, 1 + k);
  }
  const auto before = traffic();
  all.ghosts.gather({{one.data(), 1}, {three.data(), 3}});
  EXPECT_EQ(traffic().messages - before.messages, all.comm.size - 1);
  for (std::size_t g = 0; g < all.origins.size(); ++g) {
    const Origin& origin = all.origins[g];
    EXPECT_EQ(one[all.owned + g], value(origin.rank, origin.row, 0));
    for (int k = 0; k < 3; ++k)
      EXPECT_EQ(three[3 * (all.owned + g) + k], value(origin.rank, origin.row, 1 + k));
  }
}

}  // namespace
}  // namespace spall
