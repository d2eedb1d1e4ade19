#pragma once

#include <chrono>
#include <vector>

#include "engine/grasp/stopwatch.h"

namespace thenar {

/// How often a problem is solved for its times: until one of the two is spent, and once at least.
struct Repetition {
  int most = 100;
  double time_s = 1.0;
};

/// Collects the times of solves.
class SolveTimes {
 public:
  explicit SolveTimes(const Repetition& repetition) : repetition_(repetition) {}

  /// Whether to go on: a solve that warmed the machine up counts only where there is no time for another one.
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

  /// Microseconds of each solve.
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

/// Microseconds of solves, after one that warms the machine up. `reset` comes before each, and is not timed.
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
