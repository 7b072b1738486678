// Cartesian multipoles of 1/r: moments of a cell, their field at another cell, and its shifts.
// SPDX-License-Identifier: BSD-3-Clause
//
// With multi-indices n = (nx, ny, nz), |n| = nx + ny + nz, n! = nx! ny! nz!:
//   moments      M_n = sum_j m_j s_j^n / n!            about the cell's centre of mass
//   derivatives  D_n(R) = d^n (1/|R|)
//   field        psi(c + y) = sum_k L_k y^k / k!,  L_k = (-1)^|k| sum_n M_n D_{n+k}(R)
// with R from the cell that feels to the one that is felt, and |n| + |k| <= P. This cut is the same
// seen from either cell, so the forces of two cells on each other cancel exactly (Dehnen 2002).
//
// 1/|R| is harmonic: D_n + D_n' + D_n'' = 0 for n = (nx, ny, nz), n' = (nx + 2, ny, nz - 2),
// n'' = (nx, ny + 2, nz - 2). So of the derivatives, and of moments and fields that meet them,
// those with nz < 2 suffice, 2 |n| + 1 of each order. It saves a third to half of the products.
#pragma once

#include <array>
#include <utility>

#include "spall/lanes.hpp"
#include "spall/types.hpp"

namespace spall {

/// Number of multi-indices with |n| <= order.
constexpr int term_count(int order) {
  return (order + 1) * (order + 2) * (order + 3) / 6;
}

struct MultiIndex {
  int x, y, z;
  constexpr int order() const { return x + y + z; }
  constexpr int operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
  constexpr MultiIndex operator+(MultiIndex o) const { return {x + o.x, y + o.y, z + o.z}; }
  constexpr MultiIndex operator-(MultiIndex o) const { return {x - o.x, y - o.y, z - o.z}; }
  constexpr bool inside(MultiIndex o) const { return x <= o.x && y <= o.y && z <= o.z; }
  /// Place in arrays: by order, then x before y before z.
  constexpr int place() const { return term_count(order() - 1) + (y + z) * (y + z + 1) / 2 + z; }
  /// Among those with z < 2.
  constexpr int harmonic_place() const {
    return order() * order() + (z == 0 ? y : order() + 1 + y);
  }
};

/// Number of multi-indices with |n| <= order and nz < 2.
constexpr int harmonic_count(int order) {
  return (order + 1) * (order + 1);
}

constexpr MultiIndex unit_index(int axis) {
  return {axis == 0, axis == 1, axis == 2};
}

template <int P>
inline constexpr auto multi_indices = [] {
  std::array<MultiIndex, term_count(P)> all{};
  for (int x = 0; x <= P; ++x)
    for (int y = 0; x + y <= P; ++y)
      for (int z = 0; x + y + z <= P; ++z) all[MultiIndex{x, y, z}.place()] = {x, y, z};
  return all;
}();

template <int P>
inline constexpr auto harmonic_indices = [] {
  std::array<MultiIndex, harmonic_count(P)> all{};
  for (MultiIndex n : multi_indices<P>)
    if (n.z < 2) all[n.harmonic_place()] = n;
  return all;
}();

/// Calls f with the compile-time numbers 0 … N-1: loops over multi-indices leave no arithmetic on
/// indices to the run.
template <int N, class F>
[[gnu::always_inline]] inline void unroll(F&& f) {
  [&]<int... k>(std::integer_sequence<int, k...>) {
    (f(std::integral_constant<int, k>{}), ...);
  }
  (std::make_integer_sequence<int, N>{});
}

/// One product of a sum over multi-indices, sums[to] += a[from] * b[with], by places.
struct Product {
  int to, from, with;
};

/// Those that `list` names: it calls what it is given with each.
template <auto list>
inline constexpr auto products = [] {
  constexpr int count = [] {
    int n = 0;
    list([&](Product) { ++n; });
    return n;
  }();
  std::array<Product, count> all{};
  int n = 0;
  list([&](Product product) { all[n++] = product; });
  return all;
}();

/// Adds them, unrolled. By a list, and by pointers: compilers take a minute to leave out the terms
/// that an unrolled loop over all pairs of multi-indices would skip, and to look up operators.
template <auto list, class A, class T>
[[gnu::always_inline]] inline void add_products(T* sums, const A* a, const T* b) {
  [&]<int... k>(std::integer_sequence<int, k...>) {
    constexpr const Product* all = products<list>.data();
    ((sums[all[k].to] += a[all[k].from] * b[all[k].with]), ...);
  }
  (std::make_integer_sequence<int, static_cast<int>(products<list>.size())>{});
}

/// s^n / n! for |n| <= P.
template <int P, class T>
[[gnu::always_inline]] inline std::array<T, term_count(P)> powers(const T& x, const T& y,
                                                                  const T& z) {
  std::array<T, term_count(P)> result;
  result[0] = T{} + 1.0;
  const std::array<T, 3> s{x, y, z};
  unroll<term_count(P)>([&](auto k) {
    constexpr MultiIndex n = multi_indices<P>[k];
    if constexpr (n.order() > 0) {
      constexpr int axis = n.x > 0 ? 0 : n.y > 0 ? 1 : 2;
      result[k] = result[(n - unit_index(axis)).place()] * (s[axis] * (1.0 / n[axis]));
    }
  });
  return result;
}

/// The two that a multi-index with nz >= 2 follows from.
constexpr std::array<MultiIndex, 2> harmonic_parents(MultiIndex n) {
  return {MultiIndex{n.x + 2, n.y, n.z - 2}, MultiIndex{n.x, n.y + 2, n.z - 2}};
}

/// Moments with nz >= 2 go over to those that act as they do.
template <int P>
[[gnu::always_inline]] inline void fold(std::array<double, term_count(P)>& moments) {
  unroll<term_count(P)>([&](auto step) {
    constexpr MultiIndex n = multi_indices<P>[term_count(P) - 1 - step];  // parents come later
    if constexpr (n.z >= 2)
      for (MultiIndex parent : harmonic_parents(n)) moments[parent.place()] -= moments[n.place()];
  });
}

/// Terms with nz >= 2 from the others.
template <int P, class T>
[[gnu::always_inline]] inline void unfold(std::array<T, term_count(P)>& terms) {
  unroll<term_count(P)>([&](auto k) {
    constexpr MultiIndex n = multi_indices<P>[k];
    if constexpr (n.z >= 2) {
      constexpr auto parents = harmonic_parents(n);
      terms[k] = -terms[parents[0].place()] - terms[parents[1].place()];
    }
  });
}

/// D_n for |n| <= P, eight separations at once; all 0 where the separation is 0.
/// With f_m = (-1)^m (2m-1)!!/r^(2m+1): R^m_0 = f_m, R^m_{n+e} = n_e R^{m+1}_{n-e} + s_e R^{m+1}_n,
/// D = R^0 (McMurchie & Davidson 1978).
template <int P>
[[gnu::always_inline]] inline std::array<Lanes, term_count(P)> derivatives(const Lanes& x,
                                                                           const Lanes& y,
                                                                           const Lanes& z,
                                                                           const Lanes& inverse) {
  const std::array<Lanes, 3> s{x, y, z};
  const Lanes inverse2 = inverse * inverse;
  std::array<std::array<Lanes, term_count(P)>, P + 1> r;
  r[0][0] = inverse;
  for (int m = 0; m < P; ++m) r[m + 1][0] = r[m][0] * inverse2 * -(2.0 * m + 1);
  unroll<P>([&](auto step) {
    constexpr int m = P - 1 - step;
    unroll<term_count(P - m)>([&](auto k) {
      constexpr MultiIndex n = multi_indices<P>[k];
      if constexpr (n.order() > 0 && n.z < 2) {
        // The axis with the smallest exponent: an exponent of 1 costs one multiplication.
        constexpr auto rank = [](int e) { return e == 0 ? 1000 : e; };
        constexpr int axis = rank(n.x) <= rank(n.y) && rank(n.x) <= rank(n.z) ? 0
                             : rank(n.y) <= rank(n.z)                         ? 1
                                                                              : 2;
        constexpr MultiIndex less = n - unit_index(axis);
        r[m][k] = s[axis] * r[m + 1][less.place()];
        if constexpr (n[axis] > 1)
          r[m][k] += (n[axis] - 1.0) * r[m + 1][(less - unit_index(axis)).place()];
      }
    });
  });
  unfold<P>(r[0]);
  return r[0];
}

/// The moments of a cell in one row, as the kernels read them: mass, centre of mass (in the place
/// of the dipole, which is zero about it), folded orders 2 … P-1, mean velocity, sum of
/// m |v - mean|.
template <int P>
struct Moments {
  static constexpr int velocity = harmonic_count(P - 1);
  static constexpr int spread = velocity + 3;
  static constexpr int width = (spread + 1 + 7) / 8 * 8;
  alignas(64) std::array<double, width> row{};

  Vec3 center() const { return {row[1], row[2], row[3]}; }
  Vec3 mean_velocity() const { return {row[velocity], row[velocity + 1], row[velocity + 2]}; }
};

/// The field about a cell's centre: L_k, and the bound on its rate in a form that can be shifted:
/// `rate` + `rate_by_speed` * |v - mean velocity of the cell|.
template <int P>
struct LocalField {
  std::array<double, term_count(P)> terms{};
  double rate = 0, rate_by_speed = 0;
};

}  // namespace spall
