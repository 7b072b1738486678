// Large arrays lie on huge pages: where 4 KiB pages are used, sweeps over contacts and bodies wait
// for the translation of addresses, twice to ten times as long as for the data, in virtual machines
// most of all. Linux gives huge pages where they are asked for and aligned.
// SPDX-License-Identifier: BSD-3-Clause
#include <cstddef>
#include <cstdlib>
#include <new>

#if defined(__linux__) && !defined(__SANITIZE_ADDRESS__)
#include <sys/mman.h>

namespace {

constexpr std::size_t huge_page = std::size_t{1} << 21;

void* allocate(std::size_t size, std::size_t alignment) {
  // Smaller arrays would waste more of a huge page than they use.
  const bool large = size > huge_page / 2;
  const std::size_t unit = large ? huge_page : alignment;
  const std::size_t whole = (size + unit - 1) / unit * unit;
  void* const place = unit <= alignof(std::max_align_t) ? std::malloc(size > 0 ? size : 1)
                                                        : std::aligned_alloc(unit, whole);
  if (place == nullptr) throw std::bad_alloc();
  if (large) madvise(place, whole, MADV_HUGEPAGE);  // a hint; small pages serve as well
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
