// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

namespace thenar {

/// Splits the time of a tick into its stages. Reading the clock takes no system call.
class Stopwatch {
 public:
  /// Seconds since the last lap, or since the start.
  double lap() noexcept {
    const Clock::time_point now = Clock::now();
    const double seconds = std::chrono::duration<double>(now - last_).count();
    last_ = now;
    return seconds;
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point last_ = Clock::now();
};

}  // namespace thenar
