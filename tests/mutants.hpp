// Changes that sleep in the code: SPALL_MUTANT=k wakes the k-th. See tests/mutate.py.
// SPDX-License-Identifier: BSD-3-Clause
//
// `a + at(3) + b` is a - b when the third change is awake and a + b else. The rules of the language
// find the operands: what binds more strongly than + does so before, and a is all that stood to the
// left. `a += at(3) += b` and `-at(3) * a`, whose sign is dropped, are read alike. Nothing here can
// be used at compile time: what has to be known then does not compile.
#pragma once

#include <fcntl.h>
#include <stdlib.h>
#include <sys/mman.h>

namespace spall_mutants {

inline int chosen = 0;
inline unsigned char nowhere[4096];
inline unsigned char* reached = nullptr;  ///< SPALL_MUTANTS_REACHED: a file of so many bytes

namespace {
// Before all that is initialised when a program starts. A file that all ranks share, and that
// keeps what a process wrote however it ends.
[[gnu::constructor(101)]] void begin() {
  if (reached) return;
  reached = nowhere;
  if (const char* number = ::getenv("SPALL_MUTANT")) chosen = ::atoi(number);
  if (const char* name = ::getenv("SPALL_MUTANTS_REACHED")) {
    const int file = ::open(name, O_RDWR);
    void* shared = ::mmap(nullptr, sizeof nowhere, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    if (shared == MAP_FAILED) ::abort();
    reached = static_cast<unsigned char*>(shared);
  }
}
}  // namespace

[[gnu::always_inline]] inline bool awake(int k) {
  reached[k] = 1;
  return k == chosen;
}

struct Place {
  int k;
};
[[gnu::always_inline]] inline Place at(int k) {
  return {k};
}

// A result by value: of Eigen's expressions what they stand for.
template <class T>
[[gnu::always_inline]] inline T kept(const T& x) {
  return x;
}
template <class T>
requires requires {
  typename T::PlainObject;
}
[[gnu::always_inline]] inline typename T::PlainObject kept(const T& x) {
  return x;
}

template <int op, class A>
struct Left {
  const A& a;
  int k;
};
template <int op, class B>
struct Right {
  const B& b;
  int k;
};

#define SPALL_BINARY(number, op, other)                                            \
  template <class A>                                                               \
  [[gnu::always_inline]] inline Left<number, A> operator op(const A& a, Place p) { \
    return {a, p.k};                                                               \
  }                                                                                \
  template <class A, class B>                                                      \
  requires requires(const A& a, const B& b) {                                      \
    a op b, a other b;                                                             \
  }                                                                                \
  [[gnu::always_inline]] inline auto operator op(Left<number, A> x, const B& b) {  \
    return awake(x.k) ? kept(x.a other b) : kept(x.a op b);                        \
  }
SPALL_BINARY(0, +, -)
SPALL_BINARY(1, -, +)
SPALL_BINARY(2, *, /)
SPALL_BINARY(3, /, *)
SPALL_BINARY(4, <, <=)
SPALL_BINARY(5, <=, <)
SPALL_BINARY(6, >, >=)
SPALL_BINARY(7, >=, >)
SPALL_BINARY(8, ==, !=)
SPALL_BINARY(9, !=, ==)
#undef SPALL_BINARY

#define SPALL_ASSIGNMENT(number, op, other)                                             \
  template <class B>                                                                    \
  [[gnu::always_inline]] inline Right<number, B> operator op(Place p, const B& b) {     \
    return {b, p.k};                                                                    \
  }                                                                                     \
  template <class A, class B>                                                           \
  requires requires(A && a, const B& b) {                                               \
    a op b, a other b;                                                                  \
  }                                                                                     \
  [[gnu::always_inline]] inline decltype(auto) operator op(A&& a, Right<number, B> x) { \
    if (awake(x.k)) return a other x.b;                                                 \
    return a op x.b;                                                                    \
  }
SPALL_ASSIGNMENT(0, +=, -=)
SPALL_ASSIGNMENT(1, -=, +=)
SPALL_ASSIGNMENT(2, *=, /=)
SPALL_ASSIGNMENT(3, /=, *=)
#undef SPALL_ASSIGNMENT

struct Sign {
  int k;
};
[[gnu::always_inline]] inline Sign operator-(Place p) {
  return {p.k};
}
template <class A>
requires requires(const A& a) {
  -a;
}
[[gnu::always_inline]] inline auto operator*(Sign s, const A& a) {
  return awake(s.k) ? kept(a) : kept(-a);
}

}  // namespace spall_mutants
