// The multipoles' kernels, unrolled over multi-indices, for eight cells or bodies at a time.
// SPDX-License-Identifier: BSD-3-Clause
//
// A file of its own, because compilers need their time for it.
#include "gravity/expansion.hpp"

namespace spall {

template <int P>
[[gnu::always_inline]] inline void add_folded(std::array<double, term_count(P - 1)>& moments,
                                              Moments<P>& row) {
  fold<P - 1>(moments);
  for (int k = harmonic_count(1); k < harmonic_count(P - 1); ++k)
    row.row[k] += moments[harmonic_indices<P - 1>[k].place()];
}

template <int P>
[[gnu::flatten]] void measure_bodies(std::span<const Eight> leaf, bool rates, Moments<P>& row) {
  const Vec3 center = row.center(), v = row.mean_velocity();
  double spread = 0;
  std::array<Lanes, term_count(P - 1)> sums{};
  for (const Eight& e : leaf) {
    const Lanes dx = e.vx - v.x(), dy = e.vy - v.y(), dz = e.vz - v.z();
    if (rates) spread += sum_of_lanes(e.mass * estimate_sqrt(dx * dx + (dy * dy + dz * dz)));
    const auto s = powers<P - 1>(e.x - center.x(), e.y - center.y(), e.z - center.z());
    unroll<term_count(P - 1)>([&](auto k) { sums[k] += e.mass * s[k]; });
  }
  std::array<double, term_count(P - 1)> moments;
  for (int k = 0; k < term_count(P - 1); ++k) moments[k] = sum_of_lanes(sums[k]);
  add_folded(moments, row);
  row.row[Moments<P>::spread] = spread;
}

template <int P>
[[gnu::flatten]] void add_moments(Moments<P>& whole, const Moments<P>& part) {
  const Vec3 s = part.center() - whole.center();
  const auto shift = powers<P - 1>(s.x(), s.y(), s.z());
  std::array<double, term_count(P - 1)> moments{};
  constexpr auto list = [](auto&& add) {
    for (MultiIndex to : multi_indices<P - 1>)
      for (MultiIndex from : harmonic_indices<P - 1>)
        if (to.order() >= 2 && from.inside(to) && from.order() != 1)
          add(Product{to.place(), from.harmonic_place(), (to - from).place()});
  };
  add_products<list>(moments.data(), part.row.data(), shift.data());
  add_folded(moments, whole);
  whole.row[Moments<P>::spread] +=
      part.row[Moments<P>::spread] +
      part.row[0] * (part.mean_velocity() - whole.mean_velocity()).norm();
}

template <int P>
[[gnu::flatten]] void attract_by_far(std::span<const Moments<P>* const> far,
                                     const Moments<P>& target, double radius, bool rates,
                                     LocalField<P>& field) {
  using Row = Moments<P>;
  Row nothing;  // at the target itself, where derivatives are 0
  Vec3::Map(&nothing.row[1]) = target.center();
  std::array<Lanes, harmonic_count(P)> sums{};
  Lanes rate{}, rate_by_speed{};
  for (std::size_t k = 0; k < far.size(); k += lane_count) {
    Lanes m[Row::width];
    for (int block = 0; block < Row::width; block += 8) {
      Lanes part[lane_count];
      for (std::size_t lane = 0; lane < lane_count; ++lane) {
        const Row& row = k + lane < far.size() ? *far[k + lane] : nothing;
        part[lane] = *reinterpret_cast<const Lanes*>(row.row.data() + block);
      }
      transpose(part);
      for (std::size_t n = 0; n < lane_count; ++n) m[block + n] = part[n];
    }
    const Lanes x = m[1] - target.row[1], y = m[2] - target.row[2], z = m[3] - target.row[3];
    const Lanes r2 = x * x + (y * y + z * z);
    const Lanes inverse = inverse_sqrt(r2);
    const auto d = derivatives<P>(x, y, z, inverse);
    constexpr auto list = [](auto&& add) {
      for (MultiIndex to : harmonic_indices<P>)
        for (MultiIndex from : harmonic_indices<P - 1>)
          if (from.order() != 1 && from.order() + to.order() <= P)
            add(Product{to.harmonic_place(), from.harmonic_place(), (to + from).place()});
    };
    add_products<list>(sums.data(), m, d.data());
    if (rates) {
      const Lanes vx = m[Row::velocity] - target.row[Row::velocity];
      const Lanes vy = m[Row::velocity + 1] - target.row[Row::velocity + 1];
      const Lanes vz = m[Row::velocity + 2] - target.row[Row::velocity + 2];
      // From the edge of this cell to the centre of the other.
      const Lanes edge = r2 * inverse - radius;
      const Lanes weight = select(inverse > 0.0, 1.0 / (edge * edge * edge), Lanes{});
      rate += weight * (m[Row::spread] + m[0] * estimate_sqrt(vx * vx + (vy * vy + vz * vz)));
      rate_by_speed += weight * m[0];
    }
  }
  std::array<double, term_count(P)> terms{};
  unroll<harmonic_count(P)>([&](auto to) {
    constexpr MultiIndex n = harmonic_indices<P>[to];
    terms[n.place()] = (n.order() % 2 == 0 ? 1 : -1) * sum_of_lanes(sums[to]);
  });
  unfold<P>(terms);
  for (int k = 0; k < term_count(P); ++k) field.terms[k] += terms[k];
  field.rate += sum_of_lanes(rate);
  field.rate_by_speed += sum_of_lanes(rate_by_speed);
}

template <int P>
[[gnu::flatten]] LocalField<P> shifted(const LocalField<P>& field, const Vec3& s,
                                       double velocity_change) {
  LocalField<P> result;
  const auto shift = powers<P>(s.x(), s.y(), s.z());
  constexpr auto list = [](auto&& add) {
    for (MultiIndex to : multi_indices<P>)
      for (MultiIndex from : multi_indices<P>)
        if (to.inside(from)) add(Product{to.place(), from.place(), (from - to).place()});
  };
  add_products<list>(result.terms.data(), field.terms.data(), shift.data());
  result.rate = field.rate + field.rate_by_speed * velocity_change;
  result.rate_by_speed = field.rate_by_speed;
  return result;
}

template <int P>
[[gnu::flatten]] void attract_by_field(const LocalField<P>& field, const Moments<P>& row,
                                       bool rates, std::span<Eight> leaf) {
  const Vec3 center = row.center(), v = row.mean_velocity();
  for (Eight& e : leaf) {
    const auto s = powers<P>(e.x - center.x(), e.y - center.y(), e.z - center.z());
    unroll<term_count(P)>([&](auto k) {
      constexpr MultiIndex n = multi_indices<P>[k];
      e.pull.potential += field.terms[k] * s[k];
      if constexpr (n.order() < P) {
        e.pull.x += field.terms[(n + unit_index(0)).place()] * s[k];
        e.pull.y += field.terms[(n + unit_index(1)).place()] * s[k];
        e.pull.z += field.terms[(n + unit_index(2)).place()] * s[k];
      }
    });
    if (rates) {
      const Lanes dx = e.vx - v.x(), dy = e.vy - v.y(), dz = e.vz - v.z();
      e.pull.rate +=
          field.rate + field.rate_by_speed * estimate_sqrt(dx * dx + (dy * dy + dz * dz));
    }
  }
}

#define SPALL_FOR_ORDER(P)                                                                       \
  template void measure_bodies<P>(std::span<const Eight>, bool, Moments<P>&);                    \
  template void add_moments<P>(Moments<P>&, const Moments<P>&);                                  \
  template void attract_by_far<P>(std::span<const Moments<P>* const>, const Moments<P>&, double, \
                                  bool, LocalField<P>&);                                         \
  template LocalField<P> shifted<P>(const LocalField<P>&, const Vec3&, double);                  \
  template void attract_by_field<P>(const LocalField<P>&, const Moments<P>&, bool,               \
                                    std::span<Eight>);
SPALL_FOR_ORDER(4)
SPALL_FOR_ORDER(6)
SPALL_FOR_ORDER(8)

}  // namespace spall
