// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <exception>
#include <initializer_list>
#include <new>
#include <string_view>

namespace thenar::app {

/// Returns true if this machine has the instructions that the build uses.
[[nodiscard]] inline bool host_can_run() {
#if defined(__x86_64__) && defined(__AVX2__)
  return __builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("fma") != 0;
#else
  return true;
#endif
}

/// Returns true if the main thread has the stack that commands need, some of it beyond that of the largest.
[[nodiscard]] inline bool has_stack() {
  constexpr rlim_t kLeastBytes = 256 * 1024;
  rlimit stack{};
  return getrlimit(RLIMIT_STACK, &stack) != 0 || stack.rlim_cur >= kLeastBytes;
}

inline constexpr const char* kNoStack =
    "error: the stack is limited to less than 256 kB: raise the limit (ulimit -s)\n";

/// Opens the standard streams that the program was started without, so that no file of ours gets their numbers; with
/// it what others write there. They stay as they seemed: reading or writing them fails.
inline void hold_standard_streams() {
  struct stat status {};
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fstat(stream, &status) == 0) continue;
    // The lowest free number is the stream's.
    (void)open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY);
  }
}

/// Has the program end with words and exit code 1 where memory does not suffice to unwind: destructors of JSON may not
/// throw, but allocate.
inline void tell_of_memory_at_the_end() {
  static const std::terminate_handler otherwise = std::get_terminate();
  std::set_terminate([] {
    try {
      if (const std::exception_ptr cause = std::current_exception()) std::rethrow_exception(cause);
    } catch (const std::bad_alloc&) {
      constexpr std::string_view kMessage = "not enough memory\n";
      (void)!write(STDERR_FILENO, kMessage.data(), kMessage.size());
      _exit(1);
    } catch (...) {  // It is told by the handler that was there.
    }
    otherwise();
  });
}

inline constexpr const char* kHostCannotRun =
    "error: this build is for x86-64-v3 (AVX2 and FMA); configure with -DTHENAR_ARCH=x86-64 for this machine\n";

}  // namespace thenar::app
