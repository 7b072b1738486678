// Random sequential addition: a sphere is tried at random places until it is clear of all before.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <bit>
#include <cmath>

#include "base/hash.hpp"
#include "base/random.hpp"
#include "scene/packing.hpp"
#include "scene/shape.hpp"
#include "scene/sizes.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

void read(Section& in, Packing& packing) {
  std::int64_t count = 0;
  in.need("count", "of random: spheres wholly inside the volume", count, 1);
  in.check("count", static_cast<double>(count) <= most_spheres,
           fmt::format("= {}: a group has at most {:.0f} spheres", count, most_spheres));
  packing.count = count;
  for (const char* one : {"radius", "diameter"})
    in.check(one, !in.has(one) || !in.has("sizes"), "is given beside sizes: give one of them");
  Sizes sizes;
  if (!in.table("sizes", "of random, in place of radius: unequal spheres",
                [&](Section& s) { read_sizes(s, sizes, count); }))
    return;
  packing.radius = sizes.largest;
  packing.own = sizes;
}

bool is_unequal(const Packing& packing) {
  const auto* sizes = std::any_cast<Sizes>(&packing.own);
  return sizes && sizes->smallest < sizes->largest && packing.count.value() > 1;
}

Radii radii_of(const Packing& packing, std::uint64_t seed) {
  const std::int64_t count = packing.count.value();
  const auto* sizes = std::any_cast<Sizes>(&packing.own);
  if (!sizes) return {count, {packing.radius}};
  constexpr std::uint64_t stream = 0x53495a45;  // another than that of the places
  return {count, draw_radii(*sizes, count, mix(seed ^ stream))};
}

void place(const PackingRequest& request) {
  const Radii radii = radii_of(request.packing, request.seed);
  const double all = volume_of(request.volume);
  const auto filled = [&](std::int64_t spheres) {
    double sum = 0;
    for (std::int64_t k = 0; k < spheres; ++k) sum += ball_volume(radii[k]);
    return sum / all;
  };
  const std::string wanted = fmt::format(
      "{}: {} spheres of radius {}{} m would be {:.3f} of the volume", request.place, radii.count,
      radii.smallest() < radii.largest() ? fmt::format("{:.4g} to ", radii.smallest()) : "",
      radii.largest(), filled(radii.count));
  const std::string mend =
      "enlarge the volume (random packings of equal spheres end near 0.38, and below that where "
      "few spheres lie side by side) or take a lattice";
  const double most = most_filled_at_random(request.volume, radii);
  require(filled(radii.count) <= most, "{}; at random at most {:.3f} can be: {}", wanted, most,
          mend);
  const std::int64_t placed = place_at_random(
      request.comm, request.volume, request.period, radii, request.seed, request.is_free,
      [&](const Vec3& center, double r) { request.put({.center = center, .radius = r}); });
  require(placed == radii.count, "{}; {} ({:.3f}) found a place at random: {}", wanted, placed,
          filled(placed), mend);
}

/// A set of numbers 0 … n-1.
class Bits {
 public:
  void clear(std::size_t n) { words_.assign((n + 63) / 64, 0); }
  void add(std::size_t k) { words_[k / 64] |= std::uint64_t{1} << k % 64; }
  void remove(std::size_t k) { words_[k / 64] &= ~(std::uint64_t{1} << k % 64); }
  bool has(std::size_t k) const { return words_[k / 64] >> k % 64 & 1; }
  std::span<std::uint64_t> words() { return words_; }
  bool operator==(const Bits&) const = default;

  /// Calls `f` with all that are in this set or in `other`, ascending, until it returns false.
  template <class F>
  void for_each_of_either(const Bits& other, F&& f) const {
    for (std::size_t w = 0; w < words_.size(); ++w)
      for (std::uint64_t left = words_[w] | other.words_[w]; left; left &= left - 1)
        if (!f(64 * w + static_cast<std::size_t>(std::countr_zero(left)))) return;
  }

 private:
  std::vector<std::uint64_t> words_;
};

/// The part of a volume's box in which a rank tests what is tried, and what it must know for that.
class Part {
 public:
  Part(const Comm& comm, const Volume& volume, double largest) {
    const Vec3 half = half_widths(volume);
    std::array<int, 3> along{}, axes{0, 1, 2};
    check_mpi(MPI_Dims_create(comm.size, 3, along.data()), "MPI_Dims_create");
    // The most parts lie along the longest side.
    std::ranges::stable_sort(axes, [&](int a, int b) { return half[a] > half[b]; });
    for (int k = 0, rank = comm.rank; k < 3; rank /= along[k++]) {
      low_[axes[k]] = -1 + 2.0 * (rank % along[k]) / along[k];
      high_[axes[k]] = -1 + 2.0 * (rank % along[k] + 1) / along[k];
    }
    // A sphere of radius r is tried up to r beside its point of the box, and meets others up to
    // two radii away.
    const Vec3 middle = volume.center + volume.axes * (low_ + high_).cwiseProduct(half) / 2;
    const Vec3 reach = volume.axes.cwiseAbs() * (high_ - low_).cwiseProduct(half) / 2 +
                       Vec3::Constant(3 * largest);
    near_ = {middle - reach, middle + reach};
  }

  /// Whether this rank tests what is tried at this point of the box, of which all sides are -1 to
  /// 1: one rank does.
  bool owns(const Vec3& point) const {
    return (point.array() >= low_.array()).all() && (point.array() < high_.array()).all();
  }
  /// m: spheres elsewhere meet nothing that this rank tests.
  const Eigen::AlignedBox3d& near() const { return near_; }

 private:
  Vec3 low_, high_;
  Eigen::AlignedBox3d near_;
};

/// Spheres in the order of their tries, a block of tries at a time.
class Addition {
 public:
  using IsFree = std::function<bool(const Vec3&, double radius)>;

  Addition(const Comm& comm, const Volume& volume, const Period& period, const Radii& radii,
           std::uint64_t seed, const IsFree& is_free)
      : comm_(comm),
        volume_(volume),
        period_(period),
        radii_(radii),
        is_free_(is_free),
        half_(half_widths(volume)),
        engine_(seed),
        part_(comm, volume, radii.largest()),
        spheres_(set_for(part_, volume, radii.count)) {}

  std::int64_t run(const std::function<void(const Vec3&, double radius)>& place) {
    constexpr std::int64_t most_tries_in_vain = 2'000'000;
    if ((half_.array() < radii_.largest()).any()) return 0;
    // Blocks are as long as finds places for this many: so few that hardly two of them overlap.
    const std::int64_t wanted = std::max<std::int64_t>(radii_.count / 64, 256);
    constexpr std::int64_t longest = 1 << 18;
    std::int64_t tries = std::min(2 * wanted, longest), in_vain = 0;
    while (placed_ < radii_.count && in_vain < most_tries_in_vain) {
      draw(tries);
      decide();
      const std::int64_t before = placed_;
      std::int64_t next = 0;  // try after the last that found a place
      taken_.for_each_of_either(taken_, [&](std::int64_t t) {
        in_vain += t - next;
        if (in_vain >= most_tries_in_vain) return false;
        const double r = radii_[placed_++];
        place(center(t, r), r);
        in_vain = 0;
        next = t + 1;
        return true;
      });
      in_vain += tries - next;
      const std::int64_t found = std::max<std::int64_t>(placed_ - before, 1);
      tries = std::clamp(std::clamp(tries * wanted / found, tries / 4, 4 * tries),
                         std::int64_t{1024}, longest);
    }
    return placed_;
  }

 private:
  static SphereSet set_for(const Part& part, const Volume& volume, std::int64_t count) {
    const Vec3 half = half_widths_in_world(volume);
    const Eigen::AlignedBox3d whole(volume.center - half, volume.center + half);
    const Eigen::AlignedBox3d own = part.near().intersection(whole);
    const double share = own.sizes().prod() / whole.sizes().prod();
    return {own.center(), own.sizes() / 2,
            static_cast<std::int64_t>(share * static_cast<double>(count)) + 1};
  }

  void draw(std::int64_t tries) {
    const auto coordinate = [&] { return 2 * uniform(engine_) - 1; };
    points_.clear();
    open_.clear(tries);
    for (std::int64_t t = 0; t < tries; ++t) {
      const double x = coordinate(), y = coordinate(), z = coordinate();
      points_.emplace_back(x, y, z);
      if (part_.owns(points_.back())) open_.add(t);
    }
  }

  Vec3 center(std::int64_t t, double r) const {
    return volume_.center + volume_.axes * (half_ - Vec3::Constant(r)).cwiseProduct(points_[t]);
  }

  /// Finds which tries of the block are taken. That depends on those before alone, of which other
  /// ranks test some: each rank decides by what they said last, until nobody says anything new.
  /// Every time at least one try more is right for good, and most often all are after two.
  void decide() {
    const std::int64_t settled = spheres_.size();
    const std::int64_t last = std::min(placed_ + std::ssize(points_), radii_.count) - 1;
    // What a gap may change by until the block's last radius: its sphere moves with it, too.
    const double slack = (1 + std::sqrt(3.0)) * (radii_[placed_] - radii_[last]);
    taken_.clear(points_.size());
    for (;;) {
      Bits own;
      own.clear(points_.size());
      spheres_.keep(settled);
      std::int64_t k = placed_;
      taken_.for_each_of_either(open_, [&](std::int64_t t) {
        const double r = radii_[k];
        const Vec3 x = center(t, r);
        if (open_.has(t)) {
          if (!is_clear(t, x, r, settled, slack)) return true;
          own.add(t);
        }
        add(x, r);
        return ++k < radii_.count;
      });
      if (comm_.size > 1) comm_.any(own.words());
      const bool all_said = comm_.size == 1 || own == taken_;
      std::swap(taken_, own);
      if (all_said) return;
    }
  }

  /// Whether the sphere is wholly inside and meets nothing. A try of which that can never be, with
  /// whatever radius of those that are left and whatever else this block places, is closed.
  bool is_clear(std::int64_t t, const Vec3& x, double r, std::int64_t settled, double slack) {
    const auto closes = [&](const auto& hit) {
      return hit && hit->sphere < settled && hit->depth > slack;
    };
    // The depth in a mesh costs more than all else, in other volumes less.
    const bool is_mesh = volume_.mesh != nullptr;
    auto hit = is_mesh ? spheres_.find_overlap(x, r, 0) : std::nullopt;
    if (closes(hit)) {
      open_.remove(t);
      return false;
    }
    const double deep = depth(volume_, x) - r;
    if (!is_mesh && deep >= 0) hit = spheres_.find_overlap(x, r, 0);
    const bool free = deep >= 0 && !hit && is_free_(x, r);
    if (deep < -slack || closes(hit) || (deep >= 0 && !hit && !free && slack == 0)) open_.remove(t);
    return free;
  }

  /// The sphere and its images, those that this rank's tries may meet.
  void add(const Vec3& x, double r) {
    const Eigen::AlignedBox3d& near = part_.near();
    for_each_image(period_, x, near.center(), near.sizes() / 2, [&](const Vec3& image, bool) {
      if (near.contains(image)) spheres_.add(image, r);
    });
  }

  const Comm comm_;
  const Volume& volume_;
  const Period& period_;
  const Radii& radii_;
  const IsFree& is_free_;
  const Vec3 half_;
  std::mt19937_64 engine_;
  const Part part_;
  SphereSet spheres_;         ///< that this rank's tries may meet
  std::vector<Vec3> points_;  ///< of the block's tries, in a box of sides -1 to 1
  Bits open_;                 ///< tries that this rank tests, but for those that are closed
  Bits taken_;
  std::int64_t placed_ = 0;
};

}  // namespace

extern const PackingType random_packing;
const PackingType random_packing{.name = "random",
                                 .keeps_clear = true,
                                 .read = read,
                                 .unequal = is_unequal,
                                 .radii = radii_of,
                                 .place = place};

double most_filled_at_random(const Volume& volume, const Radii& radii) {
  // Where random sequential addition of equal spheres ends (Zhang & Torquato 2013: 0.38413). For
  // each halving of the radius another such packing may fill what is left.
  constexpr double equal = 0.3842;
  const double halvings = 1 + std::log2(radii.largest() / radii.smallest());
  const double inside = 1 - std::pow(1 - equal, halvings);
  // Spheres that lean on walls stand denser: as if the volume had a layer more, of at most this
  // part of the layer in which no centre may be.
  constexpr double beside_walls = 2;
  const Vec3 half = half_widths(volume);
  std::mt19937_64 engine(1);
  constexpr int samples = 20'000;
  int all = 0, free = 0;
  for (int k = 0; k < samples; ++k) {
    const double x = uniform(engine), y = uniform(engine), z = uniform(engine);
    const Vec3 offset = half.cwiseProduct(2 * Vec3(x, y, z) - Vec3::Ones());
    const double d = depth(volume, volume.center + volume.axes * offset);
    all += d >= 0;
    free += d >= radii.smallest();
  }
  return inside * (1 + beside_walls * (all - free) / std::max(all, 1));
}

std::int64_t place_at_random(const Comm& comm, const Volume& volume, const Period& period,
                             const Radii& radii, std::uint64_t seed,
                             const std::function<bool(const Vec3&, double radius)>& is_free,
                             const std::function<void(const Vec3&, double radius)>& place) {
  return Addition(comm, volume, period, radii, seed, is_free).run(place);
}

}  // namespace spall
