// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <malloc.h>

#include <chrono>
#include <cmath>
#include <cstddef>
#include <functional>
#include <vector>

#include "engine/loops/percentiles.h"

namespace thenar {

/// Microseconds that `work` takes.
template <typename Work>
double time_us(Work&& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count();
}

/// Microseconds of the second of two calls, or of the first where it is long: what the work needs is in the caches,
/// whoever has been at it before.
template <typename Work>
double warm_time_us(Work&& work) {
  constexpr double kLong_us = 5e3;
  const double first_us = time_us(work);
  return first_us > kLong_us ? first_us : time_us(work);
}

/// Median microseconds of each contender's round. They take turns, so that all of them see the same machine; a short
/// round follows one that is not timed, so that none pays for what the one before it left in the caches. A round of the
/// slow is not repeated for ever: from the third turn on, one that has had half a second sits out.
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

/// The worse of two errors: no number, of no answer, is the worst of all.
inline double worse(double a, double b) { return std::isnan(a) || a > b ? a : b; }

}  // namespace thenar
