// SPDX-License-Identifier: Apache-2.0
#include "tests/support/allocation_counter.h"

#include <cerrno>
#include <cstdlib>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define THENAR_SANITIZER
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
#define THENAR_SANITIZER
#endif
#endif

#if defined(__GLIBC__) && !defined(THENAR_SANITIZER)
#define THENAR_COUNTS_MALLOC
#endif

namespace {

// Plain and zero-initialised: reading it from inside malloc must not itself need memory.
thread_local std::int64_t allocations = 0;

}  // namespace

namespace thenar {

std::int64_t AllocationCounter::total() { return allocations; }

bool AllocationCounter::is_available() {
#ifdef THENAR_COUNTS_MALLOC
  return true;
#else
  return false;
#endif
}

}  // namespace thenar

#ifdef THENAR_COUNTS_MALLOC

// The linker takes these before glibc's own; free() stays glibc's, which the __libc functions belong to.
extern "C" {

void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* old, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);

void* malloc(std::size_t size) {
  ++allocations;
  return __libc_malloc(size);
}

void* calloc(std::size_t count, std::size_t size) {
  ++allocations;
  return __libc_calloc(count, size);
}

void* realloc(void* old, std::size_t size) {
  ++allocations;
  return __libc_realloc(old, size);
}

void* memalign(std::size_t alignment, std::size_t size) {
  ++allocations;
  return __libc_memalign(alignment, size);
}

void* aligned_alloc(std::size_t alignment, std::size_t size) {
  ++allocations;
  return __libc_memalign(alignment, size);
}

int posix_memalign(void** result, std::size_t alignment, std::size_t size) {
  ++allocations;
  *result = __libc_memalign(alignment, size);
  return *result == nullptr ? ENOMEM : 0;
}

}  // extern "C"

#endif
