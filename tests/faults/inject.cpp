// SPDX-License-Identifier: Apache-2.0
// Preloaded into a program, makes calls of the C library fail as the system might:
//     FAULT=CALL:ERRNO:AT[:once]
// From the AT-th CALL on (counted from 1; with `once`, at that one alone) it fails with this errno. Files alone are
// looked at, no terminals, pipes or sockets; allocations fail from 4 KiB up, so that a program can still say so.
//     CALL   open, read, write, sync, rename, malloc
// FAULT_IN=NAME: in the programs whose names begin so alone, and in none that they start.

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>

extern "C" {
void* __libc_malloc(size_t);
void* __libc_calloc(size_t, size_t);
void* __libc_realloc(void*, size_t);
void* __libc_memalign(size_t, size_t);
}

namespace {

constexpr size_t kLargeAllocation = 4096;

struct Fault {
  char call[16] = "";
  int error = 0;
  long at = 0;
  bool once = false;
};

int error_of(const char* name) {
  const struct {
    const char* name;
    int value;
  } known[] = {{"ENOSPC", ENOSPC}, {"EIO", EIO}, {"EMFILE", EMFILE}, {"ENOMEM", ENOMEM}, {"EACCES", EACCES}};
  for (const auto& error : known) {
    if (std::strcmp(error.name, name) == 0) return error.value;
  }
  return EIO;
}

Fault asked() {
  Fault fault;
  const char* text = std::getenv("FAULT");
  if (text == nullptr) return fault;
  if (const char* in = std::getenv("FAULT_IN")) {
    char path[4096] = "";
    const ssize_t size = readlink("/proc/self/exe", path, sizeof path - 1);
    const char* name = size > 0 ? std::strrchr(path, '/') : nullptr;
    if (name == nullptr || std::strncmp(name + 1, in, std::strlen(in)) != 0) return fault;
  }
  char error[16] = "", how[16] = "";
  if (std::sscanf(text, "%15[^:]:%15[^:]:%ld:%15s", fault.call, error, &fault.at, how) < 3) return {};
  fault.error = error_of(error);
  fault.once = std::strcmp(how, "once") == 0;
  return fault;
}

Fault fault;
std::atomic<long> calls{0};

__attribute__((constructor)) void begin() { fault = asked(); }

bool fails(const char* call) {
  if (fault.at == 0 || std::strcmp(fault.call, call) != 0) return false;
  const long now = ++calls;
  if (fault.once ? now != fault.at : now < fault.at) return false;
  errno = fault.error;
  return true;
}

bool is_file(int fd) {
  struct stat status;
  return fstat(fd, &status) == 0 && S_ISREG(status.st_mode);
}

/// The next definition of a function, ours aside.
template <typename Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

bool opens_a_file(const char* path) {
  return std::strncmp(path, "/proc", 5) != 0 && std::strncmp(path, "/sys", 4) != 0 &&
         std::strncmp(path, "/dev", 4) != 0;
}

}  // namespace

extern "C" {

int open(const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const mode_t mode = va_arg(more, mode_t);
  va_end(more);
  if (opens_a_file(path) && fails("open")) return -1;
  static auto* real = next<int(const char*, int, ...)>("open");
  return real(path, flags, mode);
}
int open64(const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const mode_t mode = va_arg(more, mode_t);
  va_end(more);
  if (opens_a_file(path) && fails("open")) return -1;
  static auto* real = next<int(const char*, int, ...)>("open64");
  return real(path, flags, mode);
}
FILE* fopen(const char* path, const char* mode) {
  if (opens_a_file(path) && fails("open")) return nullptr;
  static auto* real = next<FILE*(const char*, const char*)>("fopen");
  return real(path, mode);
}
FILE* fopen64(const char* path, const char* mode) {
  if (opens_a_file(path) && fails("open")) return nullptr;
  static auto* real = next<FILE*(const char*, const char*)>("fopen64");
  return real(path, mode);
}
ssize_t read(int fd, void* buffer, size_t size) {
  if (is_file(fd) && fails("read")) return -1;
  static auto* real = next<ssize_t(int, void*, size_t)>("read");
  return real(fd, buffer, size);
}
ssize_t write(int fd, const void* buffer, size_t size) {
  if (is_file(fd) && fails("write")) return -1;
  static auto* real = next<ssize_t(int, const void*, size_t)>("write");
  return real(fd, buffer, size);
}
ssize_t writev(int fd, const iovec* parts, int count) {
  if (is_file(fd) && fails("write")) return -1;
  static auto* real = next<ssize_t(int, const iovec*, int)>("writev");
  return real(fd, parts, count);
}
int fsync(int fd) {
  if (fails("sync")) return -1;
  static auto* real = next<int(int)>("fsync");
  return real(fd);
}
int fdatasync(int fd) {
  if (fails("sync")) return -1;
  static auto* real = next<int(int)>("fdatasync");
  return real(fd);
}
int rename(const char* from, const char* to) {
  if (fails("rename")) return -1;
  static auto* real = next<int(const char*, const char*)>("rename");
  return real(from, to);
}

void* malloc(size_t size) { return size >= kLargeAllocation && fails("malloc") ? nullptr : __libc_malloc(size); }
void* calloc(size_t count, size_t size) {
  return count * size >= kLargeAllocation && fails("malloc") ? nullptr : __libc_calloc(count, size);
}
void* realloc(void* old, size_t size) {
  return size >= kLargeAllocation && fails("malloc") ? nullptr : __libc_realloc(old, size);
}
void* aligned_alloc(size_t alignment, size_t size) {
  return size >= kLargeAllocation && fails("malloc") ? nullptr : __libc_memalign(alignment, size);
}
int posix_memalign(void** memory, size_t alignment, size_t size) {
  if (size >= kLargeAllocation && fails("malloc")) return ENOMEM;
  *memory = __libc_memalign(alignment, size);
  return *memory == nullptr ? ENOMEM : 0;
}
}
