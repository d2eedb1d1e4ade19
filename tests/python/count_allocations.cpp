// SPDX-License-Identifier: Apache-2.0
#include <atomic>
#include <cstddef>

// Counts what a process asks malloc for, where it is preloaded.

extern "C" {

void* __libc_malloc(std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);

namespace {
std::atomic<long> count{0};
}

void* malloc(std::size_t size) {
  count.fetch_add(1, std::memory_order_relaxed);
  return __libc_malloc(size);
}

void* aligned_alloc(std::size_t alignment, std::size_t size) {
  count.fetch_add(1, std::memory_order_relaxed);
  return __libc_memalign(alignment, size);
}

long thenar_allocations() { return count.load(std::memory_order_relaxed); }
}
