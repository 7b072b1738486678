// A free body turns about one of its axes after another: the arithmetic, of one body or of a lane
// each.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cmath>

#include "spall/lanes.hpp"

namespace spall {

template <class Number>
using Triple = std::array<Number, 3>;

/// As `Turn`; the quaternion as x, y, z, w.
template <class Number>
struct SplitTurn {
  std::array<Number, 4> orientation;
  Triple<Number> spin;
};

template <class Number>
struct CosSin {
  Number cos, sin;
};

/// Where angles are not small: by the library.
inline void mend_large(double x, double small, CosSin<double>& of) {
  if (std::abs(x) > small) of = {std::cos(x), std::sin(x)};
}
inline void mend_large(const Lanes& x, double small, CosSin<Lanes>& of) {
  if (!any_lane((x > small) | (x < -small))) [[likely]]
    return;
  for (std::size_t l = 0; l < lane_count; ++l)
    if (std::abs(x[l]) > small) {
      of.cos[l] = std::cos(x[l]);
      of.sin[l] = std::sin(x[l]);
    }
}

/// To round-off. Angles of a step are small, and a series is then much the faster.
template <class Number>
CosSin<Number> cos_sin(const Number& x) {
  constexpr double small = 0.25;  // the next terms are then x^14/14! < 1e-19
  constexpr auto ratio = [](int n) { return -1.0 / (n * (n - 1)); };  // of a term to the last one
  const Number y = x * x;
  const auto series = [&y](double last, auto... ratios) {
    Number sum = y * last + 1.0;
    ((sum = y * ratios * sum + 1.0), ...);
    return sum;
  };
  CosSin<Number> of{series(ratio(12), ratio(10), ratio(8), ratio(6), ratio(4), ratio(2)),
                    x * series(ratio(13), ratio(11), ratio(9), ratio(7), ratio(5), ratio(3))};
  mend_large(x, small, of);
  return of;
}

/// Turns the orientation `q` about its own axis k, and `l`, in the body's axes, back by as much.
template <int k, class Number>
void turn_about(const Number& half_angle, std::array<Number, 4>& q, Triple<Number>& l) {
  constexpr int a = (k + 1) % 3, b = (k + 2) % 3, w = 3;
  const auto [c, s] = cos_sin(half_angle);
  q = [&, before = q] {
    std::array<Number, 4> now;
    now[w] = c * before[w] - s * before[k];
    now[k] = c * before[k] + s * before[w];
    now[a] = c * before[a] + s * before[b];
    now[b] = c * before[b] - s * before[a];
    return now;
  }();
  const Number whole_c = c * c - s * s, whole_s = c * s + c * s, at = l[a];
  l[a] = whole_c * at + whole_s * l[b];
  l[b] = whole_c * l[b] - whole_s * at;
}

/// Of a unit quaternion: its columns are the body's axes in the world's.
template <class Number>
std::array<Triple<Number>, 3> axes_of(const std::array<Number, 4>& q) {
  const auto& [x, y, z, w] = q;
  const Number x2 = x + x, y2 = y + y, z2 = z + z;
  const Number xx = x * x2, yy = y * y2, zz = z * z2, xy = x * y2, xz = x * z2, yz = y * z2;
  const Number wx = w * x2, wy = w * y2, wz = w * z2;
  return {{{1.0 - (yy + zz), xy + wz, xz - wy},
           {xy - wz, 1.0 - (xx + zz), yz + wx},
           {xz + wy, yz - wx, 1.0 - (xx + yy)}}};
}
template <class Number>
Triple<Number> in_body(const std::array<Triple<Number>, 3>& axes, const Triple<Number>& v) {
  Triple<Number> turned;
  for (int k = 0; k < 3; ++k) turned[k] = axes[k][0] * v[0] + axes[k][1] * v[1] + axes[k][2] * v[2];
  return turned;
}
template <class Number>
Triple<Number> in_world(const std::array<Triple<Number>, 3>& axes, const Triple<Number>& v) {
  Triple<Number> turned;
  for (int k = 0; k < 3; ++k) turned[k] = axes[0][k] * v[0] + axes[1][k] * v[1] + axes[2][k] * v[2];
  return turned;
}
template <class Number>
Triple<Number> scaled(const Triple<Number>& by, const Triple<Number>& v) {
  return {by[0] * v[0], by[1] * v[1], by[2] * v[2]};
}

/// As `turn_freely` (engine/free_turn.hpp).
template <class Number>
SplitTurn<Number> split_turn(const Triple<Number>& inertia, const SplitTurn<Number>& from,
                             double h) {
  const Triple<Number> inverse{1.0 / inertia[0], 1.0 / inertia[1], 1.0 / inertia[2]};
  const auto before = axes_of(from.orientation);
  Triple<Number> l = scaled(inertia, in_body(before, from.spin));
  const Triple<Number> momentum = in_world(before, l);  // it stays
  std::array<Number, 4> q = from.orientation;
  turn_about<0>(h / 4 * inverse[0] * l[0], q, l);
  turn_about<1>(h / 4 * inverse[1] * l[1], q, l);
  turn_about<2>(h / 2 * inverse[2] * l[2], q, l);
  turn_about<1>(h / 4 * inverse[1] * l[1], q, l);
  turn_about<0>(h / 4 * inverse[0] * l[0], q, l);
  // Its length is 1 but for round-off.
  const Number off = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] - 1.0;
  for (Number& part : q) part = part - 0.5 * off * part;
  const auto axes = axes_of(q);
  Triple<Number> spin = in_world(axes, scaled(inverse, in_body(axes, momentum)));
  // Axes are normal to each other to round-off, which adds up over many steps.
  const Triple<Number> of_spin = in_world(axes, scaled(inertia, in_body(axes, spin)));
  const Triple<Number> left{momentum[0] - of_spin[0], momentum[1] - of_spin[1],
                            momentum[2] - of_spin[2]};
  const Triple<Number> change = in_world(axes, scaled(inverse, in_body(axes, left)));
  for (int k = 0; k < 3; ++k) spin[k] = spin[k] + change[k];
  return {q, spin};
}

}  // namespace spall
