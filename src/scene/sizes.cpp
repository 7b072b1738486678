// Laws without a unit of their own: radii are drawn over a radius of the law.
// SPDX-License-Identifier: BSD-3-Clause
#include "scene/sizes.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "base/random.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

constexpr Choice<SizeLaw> size_laws[] = {
    {"power", SizeLaw::power}, {"lognormal", SizeLaw::lognormal}, {"list", SizeLaw::list}};

/// Of a lognormal law: the part of it between its limits.
double part_inside(const Sizes& sizes) {
  const auto below = [&](double r) {
    return std::erfc(-std::log(r / sizes.median) / (sizes.spread * std::sqrt(2.0))) / 2;
  };
  return below(sizes.largest) - below(sizes.smallest);
}

/// How many of `count` spheres have each radius: rounded down, and up where most was cut off.
std::vector<std::int64_t> counts_of(const std::vector<double>& shares, std::int64_t count) {
  std::vector<std::int64_t> counts;
  std::vector<double> cut;
  for (double share : shares) {
    const double wanted = share * static_cast<double>(count);
    counts.push_back(static_cast<std::int64_t>(wanted));
    cut.push_back(wanted - std::floor(wanted));
  }
  std::vector<std::size_t> order(shares.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, std::greater(), [&](std::size_t k) { return cut[k]; });
  std::int64_t missing = count - std::accumulate(counts.begin(), counts.end(), std::int64_t{0});
  for (std::size_t k = 0; missing > 0; ++k, --missing) ++counts[order[k % order.size()]];
  return counts;
}

void read_list(Section& in, Sizes& sizes, std::int64_t count) {
  in.need("radii", "of list", sizes.radii, positive(dimension::length));
  in.take("shares", "of list: of the number of spheres, over their sum; left out: equal",
          sizes.shares, positive(dimension::number));
  if (sizes.shares.empty()) sizes.shares.assign(sizes.radii.size(), 1);
  in.check("shares", sizes.shares.size() == sizes.radii.size(), "are not as many as radii");
  if (sizes.radii.empty()) return in.check("radii", !in.has("radii"), "is empty");
  const double all = std::accumulate(sizes.shares.begin(), sizes.shares.end(), 0.0);
  for (double& share : sizes.shares) share /= all;
  in.check("shares", std::ranges::min(counts_of(sizes.shares, count)) > 0,
           "has one that is less than a sphere");
  sizes.smallest = std::ranges::min(sizes.radii);
  sizes.largest = std::ranges::max(sizes.radii);
}

/// Over `smallest`, of a power law: the inverse of its distribution.
double power_at(const Sizes& sizes, double u) {
  const double ratio = sizes.largest / sizes.smallest;
  if (sizes.exponent == 0) return std::pow(ratio, u);
  return std::pow(1 - u * (1 - std::pow(ratio, -sizes.exponent)), -1 / sizes.exponent);
}

}  // namespace

void read_sizes(Section& in, Sizes& sizes, std::int64_t count) {
  using namespace dimension;
  in.need("law", "of the number of spheres over their radius", sizes.law, size_laws);
  const bool is_list = sizes.law == SizeLaw::list;
  if (in.reads(!is_list)) {
    in.need("smallest", "of power, lognormal: radius", sizes.smallest, positive(length));
    in.need("largest", "of power, lognormal: radius", sizes.largest, positive(length));
    in.check("largest", sizes.largest >= sizes.smallest, "is less than smallest");
  }
  if (in.reads(sizes.law == SizeLaw::power))
    in.need("exponent", "of power: N(>r) ~ r^-exponent", sizes.exponent, any(number));
  if (in.reads(sizes.law == SizeLaw::lognormal)) {
    in.need("median", "of lognormal, before smallest and largest cut it: radius", sizes.median,
            positive(length));
    in.need("spread", "of lognormal: standard deviation of ln r", sizes.spread, positive(number));
    constexpr double least = 0.01;
    in.check("median", !(sizes.median > 0 && sizes.spread > 0) || part_inside(sizes) >= least,
             "and spread leave less than a hundredth between smallest and largest");
  }
  if (in.reads(is_list)) read_list(in, sizes, count);
}

std::vector<double> draw_radii(const Sizes& sizes, std::int64_t count, std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  std::vector<double> radii;
  radii.reserve(count);
  const auto draw = [&] {
    if (sizes.law == SizeLaw::power)
      return std::clamp(sizes.smallest * power_at(sizes, uniform(engine)), sizes.smallest,
                        sizes.largest);
    for (;;) {
      const double r = sizes.median * std::exp(sizes.spread * normal(engine));
      if (r >= sizes.smallest && r <= sizes.largest) return r;
    }
  };
  if (sizes.law == SizeLaw::list) {
    const std::vector<std::int64_t> counts = counts_of(sizes.shares, count);
    for (std::size_t k = 0; k < counts.size(); ++k)
      radii.insert(radii.end(), counts[k], sizes.radii[k]);
  } else {
    for (std::int64_t k = 0; k < count; ++k) radii.push_back(draw());
  }
  std::ranges::sort(radii, std::greater());
  return radii;
}

}  // namespace spall
