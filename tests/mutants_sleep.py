#!/usr/bin/env python3
# Changes that sleep: asleep the code does as before, awake as if its text had been changed.
# SPDX-License-Identifier: BSD-3-Clause
"""usage: mutants_sleep.py COMPILER EIGEN    the compiler, and the folder of Eigen's headers

A text is compiled once with all changes asleep, and once for each change with that one made. What
they print must be the same where SPALL_MUTANT names the change; and changes are told as reached
if their place was come to.
"""
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from mutants import KINDS, code_only, edits, find_places, with_sleeping

ROOT = Path(__file__).resolve().parent.parent
CODE = r"""
constexpr double half = 0.5, steep = 3 * half;
constexpr struct {
  int number;
  double part;
} named[] = {{1, 0.25}, {-2, 0.75}};
struct Span {
  static constexpr int most = 7;
  int first = -1;
  bool empty() const { return first < 0; }
};
inline int asked = 0;
inline bool ask(bool answer) {
  ++asked;
  return answer;
}
inline double at_least(double x, double low = -4.5) {
  return x > low ? x : low;
}
inline Vec3 turned(const Vec3& v, double angle) {
  Vec3 r = -v.cross(Vec3(0, 0, 1)) * angle + v * (1 - angle);
  r += v / 4;
  r *= 1 + angle;
  r.head<2>() -= v.tail<2>();
  return r / r.norm();
}
inline Lanes law(const Lanes& x, double k) {
  Lanes f = -k * x + 2.0;
  f += x * x;
  const Lanes capped = select(f < 8.0, f, x - 2.0 * f);
  return select(x >= 1.0, capped, -capped / (k + x));
}
inline unsigned long count(unsigned long n, int less, const double* beside) {
  if (!beside || beside[0] == 3 || (n > 2 && less != 1 && beside[1] <= 1)) n *= 2;
  unsigned long all = 0;
  for (unsigned long k = 1; k < n; k += 2) all += k % 3 + n / 5 - less;
  return all - 2 * n / 7 * 3;
}
inline void show() {
  Span span;
  print(steep - half / 2, span.empty(), span.first, Span::most, named[0].part, named[1].number);
  print(at_least(-5.25), at_least(-4.5), at_least(1e-3));
  const Vec3 a = turned(Vec3(1, 2, 3), 0.25), b = turned(a, -2);
  print(a.x(), a.y(), a.z(), b.dot(-a), (a - b).squaredNorm());
  const Lanes lanes = law(Lanes(-1, 0, 1, 2, 3, 4.5, 6, 9), 1.5);
  for (double lane : lanes.at) print(lane);
  const double values[] = {0, 4, 2, 1, 5, 3, 0}, *in = &values[2];
  print(count(9, 1, in), count(10, 2, in), count(2, 4, nullptr), count(3, -1, in + 1));
  const bool mixed = ask(false) || ask(true) && ask(false) || ask(true), both = mixed && ask(true);
  print(mixed, both, asked, 3 - asked * 2, asked / 2);
  asked = 6;
  asked /= 2;
  ask(true);
  print(asked);
  const unsigned char small = 200;
  const std::string name = "s && 1";
  print(-small, small + 100, name == "s && 1" && name != "s", 7 / 2, 7.0 / 2);
}
"""
NEVER = """
inline double never(double x) {
  return x + 1;
}
"""
FRAME = r"""
#include <Eigen/Geometry>
#include <cstdio>
#include <cstdlib>
#include <string>
#include "{header}"
#include "spall/lanes.hpp"
using namespace spall;
using Vec3 = Eigen::Vector3d;
template <class... T>
void print(const T&... values) {{
  (std::printf("%.17g ", static_cast<double>(values)), ...);
  std::puts("");
}}
{versions}
int main(int, char** argv) {{
  void (*const shown[])() = {{{shown}}};
  shown[std::atoi(argv[1])]();
}}
"""


def main(compiler, eigen):
    text, header = CODE + NEVER, ROOT / "tests" / "mutants.hpp"
    found = find_places({"text": text}, None, KINDS)
    places = dict(enumerate(((kind, *place) for kind in KINDS for _, *place in found[kind]), 1))
    assert all(edits(text, code_only(text), k, *place) for k, place in places.items())
    versions = [with_sleeping(text, places, header).split("\n", 2)[2]]
    versions += [text[:at] + after + text[at + len(before):]
                 for _, at, before, after in places.values()]
    wrong = 0
    with tempfile.TemporaryDirectory() as folder:
        program, reached = f"{folder}/shown", Path(folder) / "reached"
        Path(f"{program}.cpp").write_text(FRAME.format(
            header=header, shown=", ".join(f"v{k}::show" for k in range(len(versions))),
            versions="\n".join(f"namespace v{k} {{\n{v}}}" for k, v in enumerate(versions))))
        subprocess.run([compiler, "-std=c++20", "-w", "-DSPALL_SCALAR", f"-I{ROOT / 'include'}",
                        f"-I{eigen}", f"{program}.cpp", "-o", program], check=True)

        def said(version, awake):
            reached.write_bytes(bytes(4096))
            run = subprocess.run([program, str(version)], capture_output=True, text=True,
                                 timeout=60,
                                 env=os.environ | {"SPALL_MUTANT": str(awake),
                                                   "SPALL_MUTANTS_REACHED": str(reached)})
            return f"{run.stdout}ends with {run.returncode}\n"  # some do with a signal

        plain, unseen = said(0, 0), 0
        for k, (kind, at, before, after) in places.items():
            changed, awake = said(k, 0), said(0, k)
            come_to = reached.read_bytes()[k] == 1
            unseen += awake == plain and come_to
            if awake != changed or come_to != (at < len(CODE)):
                wrong += 1
                print(f"{kind} {before!r} -> {after!r} behind {text[at - 40:at]!r}: "
                      f"{'reached' if come_to else 'not reached'}\n{awake}instead of\n{changed}")
    print(f"{len(places)} changes, {wrong} wrong, of which {unseen} are not seen")
    return 1 if wrong or unseen > len(places) / 6 else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2]))
