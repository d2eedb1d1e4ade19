// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace thenar {

/// Counts what the calling thread takes from the heap: malloc and its relatives, and so operator new and Eigen, too.
/// Linking allocation_counter.cpp puts a counting malloc before glibc's.
///
///     const AllocationCounter counter;
///     ...
///     EXPECT_EQ(counter.count(), 0);
class AllocationCounter {
 public:
  AllocationCounter() : start_(total()) {}

  /// Allocations of this thread since the counter was made.
  [[nodiscard]] std::int64_t count() const { return total() - start_; }

  /// False where malloc belongs to somebody else (sanitizers, another C library): the count then stays zero.
  [[nodiscard]] static bool is_available();

 private:
  [[nodiscard]] static std::int64_t total();
  std::int64_t start_;
};

}  // namespace thenar
