// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

namespace thenar {

/// Collects one number of every item: a member, or a function's value.
template <typename Things, typename Get>
[[nodiscard]] std::vector<double> collect(const Things& things, Get get) {
  std::vector<double> values;
  values.reserve(things.size());
  for (const auto& thing : things) values.push_back(static_cast<double>(std::invoke(get, thing)));
  return values;
}

/// Returns the q-percentile of a sample, 0 <= q <= 1, by nearest rank: the smallest value that at least the share q of
/// the sample does not exceed, so always a value of the sample and never below the truth for lack of data. q = 1 is the
/// maximum. NaN for an empty sample.
///
/// Requires  `sorted` in ascending order, without NaN.
[[nodiscard]] double percentile(const std::vector<double>& sorted, double q);

/// The statistics of a latency: the 50, 99 and 99.9 % percentiles of the sample, and its largest value.
struct Percentiles {
  double p50 = 0.0, p99 = 0.0, p999 = 0.0, max = 0.0;  ///< NaN for an empty sample.
};

/// Returns the mean; NaN for an empty sample.
[[nodiscard]] double mean(const std::vector<double>& values);

/// Computes the percentiles of a sample. Values that are not finite are left out.
[[nodiscard]] Percentiles percentiles(std::vector<double> values);

}  // namespace thenar
