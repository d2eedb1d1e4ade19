// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace thenar {

/// Refuses and counts the system calls of one thread, except sleeping until a time and ending the process. It cannot be
/// taken off again: for a thread of a forked child, which ends by _exit.
class SeccompTrap {
 public:
  /// False on other systems and processors, where the trap is not built, and under sanitizers, which call the system.
  [[nodiscard]] static bool is_available();

  /// Sets the trap for the calling thread; false if the system refused.
  [[nodiscard]] static bool set();

  /// System calls that were trapped so far, and the number of the last one.
  [[nodiscard]] static std::int64_t count();
  [[nodiscard]] static long last();
};

}  // namespace thenar
