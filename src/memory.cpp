// Large arrays lie on huge pages: where 4 KiB pages are used, sweeps over contacts and bodies wait
// for the translation of addresses, twice to ten times as long as for the data, in virtual machines
// most of all. Linux gives huge pages where they are asked for and aligned. What is freed stays
// with the program: the next step needs as much, and the system clears every page before it gives
// it. SPDX-License-Identifier: BSD-3-Clause
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <new>

#include "base/out_of_memory.hpp"

#if defined(__linux__) && !defined(__SANITIZE_ADDRESS__)
#include <malloc.h>
#include <sys/mman.h>

namespace {

[[maybe_unused]] const bool keeps_freed = [] {
  constexpr int most_idle = 1 << 30;  // bytes at the heap's end
  return mallopt(M_MMAP_MAX, 0) == 1 && mallopt(M_TRIM_THRESHOLD, most_idle) == 1;
}();

constexpr std::size_t small_page = std::size_t{1} << 12, huge_page = std::size_t{1} << 21;

void* allocate(std::size_t size, std::size_t alignment) {
  const std::size_t whole = (size + alignment - 1) / alignment * alignment;
  void* const place = alignment <= alignof(std::max_align_t) ? std::malloc(size > 0 ? size : 1)
                                                             : std::aligned_alloc(alignment, whole);
  if (place == nullptr) throw spall::OutOfMemory(size);
  if (size >= huge_page) {
    // Whole small pages inside of it. Arrays that began at a huge page would waste up to one of
    // them each, and glibc could not put the next array of that size where a former one was.
    const auto at = reinterpret_cast<std::uintptr_t>(place);
    const std::uintptr_t begin = (at + small_page - 1) / small_page * small_page;
    const std::uintptr_t end = (at + size) / small_page * small_page;
    madvise(reinterpret_cast<void*>(begin), end - begin, MADV_HUGEPAGE);  // a hint
  }
  return place;
}

}  // namespace

void* operator new(std::size_t size) {
  return allocate(size, alignof(std::max_align_t));
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  return allocate(size, static_cast<std::size_t>(alignment));
}
void operator delete(void* place) noexcept {
  std::free(place);
}
void operator delete(void* place, std::size_t) noexcept {
  std::free(place);
}
void operator delete(void* place, std::align_val_t) noexcept {
  std::free(place);
}
void operator delete(void* place, std::size_t, std::align_val_t) noexcept {
  std::free(place);
}
#endif
