#pragma once

#include <malloc.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <vector>

#include "bench/report/figure.h"
#include "engine/percentiles.h"

namespace thenar {

/// Microseconds that `work` takes.
template <typename Work>
double time_us(Work&& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count();
}

/// Median time of `repeats` calls, each after a `prepare` that is not timed.
template <typename Prepare, typename Work>
double median_us(int repeats, Prepare&& prepare, Work&& work) {
  std::vector<double> times;
  for (int k = 0; k < repeats; ++k) {
    prepare();
    times.push_back(time_us(work));
  }
  return percentiles(std::move(times)).p50;
}

/// Median microseconds of each contender's round. They take turns, so that all of them see the same machine; a short round
/// follows one that is not timed, so that none pays for what the one before it left in the caches. A round of the slow is
/// not repeated for ever: from the third turn on, one that has had half a second sits out.
inline std::vector<double> times_in_turns(const std::vector<std::function<void()>>& rounds, int turns) {
  constexpr double kPatience_us = 0.5e6, kShort_us = 5e3;
  std::vector<std::vector<double>> us(rounds.size());
  std::vector<double> spent_us(rounds.size(), 0.0);
  for (int turn = 0; turn < turns; ++turn) {
    for (std::size_t i = 0; i < rounds.size(); ++i) {
      if (turn >= 3 && spent_us[i] > kPatience_us) continue;
      if (turn == 0 || us[i].back() < kShort_us) rounds[i]();
      us[i].push_back(time_us(rounds[i]));
      spent_us[i] += us[i].back();
    }
  }
  std::vector<double> medians;
  for (std::vector<double>& times : us) medians.push_back(percentiles(std::move(times)).p50);
  return medians;
}

/// Bytes of the heap that are in use: the difference over a piece of work is what it has taken and kept.
inline double heap_bytes() {
  const struct mallinfo2 heap = mallinfo2();
  return static_cast<double>(heap.uordblks + heap.hblkhd);
}

/// The default's time over the least of any of our points that errs no more: 1 on the front. Errors that rounding makes
/// are alike.
inline double over_front(const std::vector<WorkPoint>& points) {
  const auto chosen = std::find_if(points.begin(), points.end(), [](const WorkPoint& p) { return p.is_default; });
  if (chosen == points.end()) return std::numeric_limits<double>::quiet_NaN();
  constexpr double kRounding = 1e-12;
  double least_us = chosen->us;
  for (const WorkPoint& p : points) {
    if (!p.peer && p.error <= std::max(chosen->error, kRounding)) least_us = std::min(least_us, p.us);
  }
  return chosen->us / least_us;
}

}  // namespace thenar
