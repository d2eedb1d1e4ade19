#pragma once

namespace thenar::app {

/// Returns true if this machine has the instructions that the build uses.
[[nodiscard]] inline bool host_can_run() {
#if defined(__x86_64__) && defined(__AVX2__)
  return __builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("fma") != 0;
#else
  return true;
#endif
}

inline constexpr const char* kHostCannotRun =
    "error: this build is for x86-64-v3 (AVX2 and FMA); configure with -DTHENAR_ARCH=x86-64 for this machine\n";

}  // namespace thenar::app
