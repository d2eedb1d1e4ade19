#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
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

/// p of us = c n^p, fitted by least squares of the logarithms.
inline double exponent(const std::vector<double>& n, const std::vector<double>& us) {
  double x_mean = 0.0, y_mean = 0.0, xy = 0.0, xx = 0.0;
  const auto count = static_cast<double>(n.size());
  for (std::size_t i = 0; i < n.size(); ++i) {
    x_mean += std::log(n[i]) / count;
    y_mean += std::log(us[i]) / count;
  }
  for (std::size_t i = 0; i < n.size(); ++i) {
    xy += (std::log(n[i]) - x_mean) * (std::log(us[i]) - y_mean);
    xx += (std::log(n[i]) - x_mean) * (std::log(n[i]) - x_mean);
  }
  return xy / xx;
}

}  // namespace thenar
