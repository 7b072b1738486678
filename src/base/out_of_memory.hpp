// The end of memory, with how much was wanted.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdio>
#include <new>

namespace spall {

/// What `new` of Spall's programs throws. It takes no memory for its words.
class OutOfMemory : public std::bad_alloc {
 public:
  explicit OutOfMemory(std::size_t bytes) {
    std::snprintf(text_, sizeof text_, "out of memory: %.3g MB more were wanted at once",
                  1e-6 * static_cast<double>(bytes));
  }
  const char* what() const noexcept override { return text_; }

 private:
  char text_[80];
};

}  // namespace spall
