// The vector layer against plain loops; built for each level of instructions, and as scalars.
// SPDX-License-Identifier: BSD-3-Clause
#include "spall/lanes.hpp"

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <random>
#include <vector>

namespace spall {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double ulp = std::numeric_limits<double>::epsilon();

/// Lanes 0 … 7 of 10^4 random vectors between two numbers, evenly in their logarithms.
template <class F>
void for_random(double low, double high, F&& f) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> uniform(std::log(low), std::log(high));
  for (int k = 0; k < 10000; ++k) {
    Lanes v;
    for (std::size_t l = 0; l < lane_count; ++l) v[l] = std::exp(uniform(random));
    f(v);
  }
}

template <class T>
void fill(Vector<T, lane_count> (&rows)[lane_count]) {
  for (std::size_t r = 0; r < lane_count; ++r)
    for (std::size_t l = 0; l < lane_count; ++l) rows[r][l] = static_cast<T>(10 * r + l);
}

TEST(Lanes, functions_are_those_of_the_library) {
  for_random(1e-30, 1e30, [](const Lanes& v) {
    const Lanes inverse = inverse_sqrt(v), root = root_of(v), cube = cube_root(v);
    const Lanes rough = estimate_sqrt(v), exact = square_root(v);
    for (std::size_t l = 0; l < lane_count; ++l) {
      EXPECT_NEAR(inverse[l] * std::sqrt(v[l]), 1, 2 * ulp);
      EXPECT_NEAR(root[l] / std::sqrt(v[l]), 1, 3 * ulp);
      EXPECT_NEAR(cube[l] / std::cbrt(v[l]), 1, 1e-13);
      EXPECT_NEAR(rough[l] / std::sqrt(v[l]), 1, estimate_error);
      EXPECT_EQ(exact[l], std::sqrt(v[l]));
    }
  });
  for_random(1e-6, 699, [](const Lanes& v) {
    for (const Lanes& x : {v, -v}) {
      const Lanes e = exponential(x);
      for (std::size_t l = 0; l < lane_count; ++l) EXPECT_NEAR(e[l] / std::exp(x[l]), 1, 3 * ulp);
    }
  });
  const auto logarithms = [](const Lanes& v) {
    for (std::size_t l = 0; l < lane_count; ++l)
      EXPECT_NEAR(logarithm(v)[l], std::log(v[l]), 3 * ulp * std::abs(std::log(v[l])));
  };
  for_random(1e-300, 1e300, logarithms);
  for_random(0.5, 2, logarithms);
  for_random(1 - 1e-9, 1 + 1e-9, logarithms);
  for_random(1e-9, 1e3, [](const Lanes& v) {
    for (double n : {0.0, 0.31, 1.0, 4.5})
      for (std::size_t l = 0; l < lane_count; ++l) {
        const double error = (3 + std::abs(n * std::log(v[l]))) * ulp;
        EXPECT_NEAR(power_of(v, spread(n))[l] / std::pow(v[l], n), 1, error);
      }
  });
  for (double n : {1.09, 4.0}) {
    EXPECT_LE(power_of(spread(1e-300), spread(n))[0], 1e-300);
    EXPECT_LE(power_of(Lanes{}, spread(n))[0], 1e-300);
  }
  for_random(0.1, 10, [](const Lanes& v) {
    for (int n : {0, 1, 5, 12, 13})
      for (std::size_t l = 0; l < lane_count; ++l)
        EXPECT_NEAR(power(v, n)[l] / std::pow(v[l], n), 1, 8 * ulp);
  });
}

TEST(Lanes, coincident_points_do_nothing) {
  const Lanes v{4, 0, 1, 0, 9, 16, 0, 25}, wanted{0.5, 0, 1, 0, 1 / 3., 0.25, 0, 0.2};
  for (std::size_t l = 0; l < lane_count; ++l) {
    EXPECT_NEAR(inverse_sqrt(v)[l], wanted[l], ulp);
    EXPECT_NEAR(root_of(v)[l], v[l] * wanted[l], 4 * ulp * v[l]);
  }
}

TEST(Lanes, select_takes_nothing_of_the_other_side) {
  const Lanes a{1, nan, 3, nan, 5, nan, 7, nan}, b{nan, 2, nan, 4, nan, 6, nan, 8};
  const Lanes chosen = select(mask_of_bits(0b01010101), a, b);
  for (std::size_t l = 0; l < lane_count; ++l) EXPECT_EQ(chosen[l], 1.0 + l);
}

TEST(Lanes, masks_are_bits) {
  for (unsigned bits = 0; bits < 256; ++bits) {
    const LaneMask mask = mask_of_bits(static_cast<std::uint8_t>(bits));
    EXPECT_EQ(bits_of_mask(mask), bits);
    EXPECT_EQ(bits_of_mask(~mask), 255 - bits);
    EXPECT_EQ(any_lane(mask), bits != 0);
  }
  const Lanes v{-1, 0, 1, nan, 2, -2, 0.5, 3};
  EXPECT_EQ(bits_of_mask(v > 0.0), 0b11010100);  // nothing is true of NaN
  EXPECT_EQ(bits_of_mask((v <= 0.0) | (v >= 2.0)), 0b10110011);
  EXPECT_EQ(bits_of_mask((v < 1.0) & (v > -1.0)), 0b01000010);
}

TEST(Lanes, sums_and_extremes) {
  const Lanes v{3, -1, 4, 1, -5, 9, 2, 6};
  EXPECT_EQ(sum_of_lanes(v), 19);
  EXPECT_EQ(largest_lane(v), 9);
  for (std::size_t l = 0; l < lane_count; ++l) {
    EXPECT_EQ(larger(v, spread(2))[l], std::max(v[l], 2.0));
    EXPECT_EQ(smaller(v, spread(2))[l], std::min(v[l], 2.0));
    EXPECT_EQ(convert<float>(v)[l], static_cast<float>(v[l]));
    EXPECT_EQ((-v)[l], -v[l]);
  }
}

template <class T>
void check_transposes() {
  LanesOf<T> rows[lane_count];
  fill<T>(rows);
  transpose(rows);
  for (std::size_t r = 0; r < lane_count; ++r)
    for (std::size_t l = 0; l < lane_count; ++l) EXPECT_EQ(rows[r][l], 10 * l + r);
  // Half rows, whose fourth number is nobody's.
  LanesOf<T> x, y, z;
  lanes_of_halves(
      [](int l) {
        return HalfOf<T>{T(10 * l), T(10 * l + 1), T(10 * l + 2), T(nan)};
      },
      &x, &y, &z);
  HalfOf<T> half[lane_count];
  halves_of_lanes(x, y, z, LanesOf<T>{} + T(7), half);
  for (std::size_t l = 0; l < lane_count; ++l)
    for (int k = 0; k < 4; ++k) EXPECT_EQ(half[l][k], k < 3 ? 10 * l + k : 7);
}

TEST(Lanes, transposes) {
  check_transposes<double>();
  check_transposes<float>();
}

TEST(Lanes, gathers) {
  std::vector<double> from(64, nan);
  const std::int32_t places[lane_count] = {63, 0, 5, 5, 17, 40, 2, 33};
  for (std::int32_t at : places) from[at] = 100 + at;
  const Lanes v = gather(from.data(), load(places));
  for (std::size_t l = 0; l < lane_count; ++l) EXPECT_EQ(v[l], 100 + places[l]);
  const double numbers[4] = {1, 2, 3, nan};
  const RowHalf three = load_three(numbers);
  for (int k = 0; k < 4; ++k) EXPECT_EQ(three[k], k < 3 ? 1 + k : 0);
}

TEST(Lanes, packed_numbers_come_back_and_touch_nothing_else) {
  for (unsigned bits = 0; bits < 256; ++bits) {
    std::array<double, 12> numbers;
    numbers.fill(nan);
    const auto count = static_cast<std::size_t>(std::popcount(bits));
    for (std::size_t k = 0; k < count; ++k) numbers[k] = 1.0 + k;
    const Lanes v = load_packed(numbers.data(), bits);
    for (std::size_t l = 0, k = 0; l < lane_count; ++l) EXPECT_EQ(v[l], bits >> l & 1 ? ++k : 0.0);
    std::array<double, 12> stored;
    stored.fill(-1);
    store_packed(v, bits, stored.data());
    for (std::size_t k = 0; k < stored.size(); ++k) EXPECT_EQ(stored[k], k < count ? 1.0 + k : -1);
    const IndexLanes indices{10, 11, 12, 13, 14, 15, 16, 17};
    std::array<std::int32_t, 8> chosen;
    ASSERT_EQ(store_packed(indices, bits, chosen.data()), count);
    for (std::size_t l = 0, k = 0; l < lane_count; ++l) {
      if (bits >> l & 1) {
        EXPECT_EQ(chosen[k++], indices[l]);
      }
    }
  }
}

TEST(Lanes, sum_of_a_product_and_a_number) {
  const RowHalf b{1, 2, 3, 4}, c{0.5, 0.25, -3, 0};
  const RowHalf sum = multiply_add(2.0, b, c);
  for (int k = 0; k < 4; ++k) EXPECT_EQ(sum[k], 2 * b[k] + c[k]);
}

}  // namespace
}  // namespace spall

int main(int argc, char** argv) {
#ifdef SPALL_NEEDS
  if (!__builtin_cpu_supports(SPALL_NEEDS)) return 77;  // not on this machine
#endif
  ::testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
