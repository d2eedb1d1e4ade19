// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <vector>

#include "engine/grasp/stopwatch.h"

namespace thenar {

/// The limits of repeated solves for timing: until one of the two is spent, and at least once.
struct Repetition {
  int most = 100;
  double time_s = 1.0;
};

/// A collector of the times of solves.
class SolveTimes {
 public:
  explicit SolveTimes(const Repetition& repetition) : repetition_(repetition) {}

  /// Tests whether to continue: the warm-up solve counts only if there is no time for another one.
  [[nodiscard]] bool goes_on() const {
    const double spent_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    return std::ssize(us_) < repetition_.most && spent_s < repetition_.time_s;
  }

  template <typename Solve>
  void warm_up(Solve solve) {
    warm_us_.push_back(timed_us(solve));
  }
  template <typename Solve>
  void add(Solve solve) {
    us_.push_back(timed_us(solve));
  }

  /// Returns the microseconds of each solve.
  [[nodiscard]] const std::vector<double>& us() const { return us_.empty() ? warm_us_ : us_; }

 private:
  template <typename Solve>
  static double timed_us(Solve solve) {
    Stopwatch watch;
    solve();
    return 1e6 * watch.lap();
  }

  Repetition repetition_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::vector<double> us_, warm_us_;
};

/// Returns the microseconds of solves, after a warm-up solve. `reset` is called before each, untimed.
template <typename Reset, typename Solve>
std::vector<double> time_solves(const Repetition& repetition, Reset reset, Solve solve) {
  SolveTimes times(repetition);
  reset();
  times.warm_up(solve);
  while (times.goes_on()) {
    reset();
    times.add(solve);
  }
  return times.us();
}

}  // namespace thenar
