#pragma once

#include <algorithm>
#include <chrono>
#include <vector>

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

}  // namespace thenar
