#pragma once

#include <functional>
#include <vector>

namespace thenar {

/// One number of every thing: a member of it, or what a function says of it.
template <typename Things, typename Get>
[[nodiscard]] std::vector<double> collect(const Things& things, Get get) {
  std::vector<double> values;
  values.reserve(things.size());
  for (const auto& thing : things) values.push_back(static_cast<double>(std::invoke(get, thing)));
  return values;
}

/// The q-percentile of a sample, 0 <= q <= 1, by nearest rank: the smallest value that at least the share q of the
/// sample does not exceed, so always a value of the sample and never below the truth for lack of data. q = 1 is the
/// maximum. NaN of an empty sample.
///
/// Requires  `sorted` in ascending order, without NaN.
[[nodiscard]] double percentile(const std::vector<double>& sorted, double q);

/// What is told of a latency: where half, 99 % and 99.9 % of the sample end, and its largest value.
struct Percentiles {
  double p50 = 0.0, p99 = 0.0, p999 = 0.0, max = 0.0;  ///< NaN of an empty sample.
};

/// NaN of an empty sample.
[[nodiscard]] double mean(const std::vector<double>& values);

/// Sorts its own copy of the sample. Values that are not finite are left out.
[[nodiscard]] Percentiles percentiles(std::vector<double> values);

}  // namespace thenar
