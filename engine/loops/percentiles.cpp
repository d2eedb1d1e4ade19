// SPDX-License-Identifier: Apache-2.0
#include "engine/loops/percentiles.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace thenar {

double percentile(const std::vector<double>& sorted, double q) {
  if (sorted.empty()) return std::numeric_limits<double>::quiet_NaN();
  const double count = static_cast<double>(sorted.size());
  // 0.99 * 100 is a little more than 99: the rank of a whole share must not be rounded up by that.
  const double rank = std::ceil(q * count - 1e-9 * count);
  return sorted[static_cast<std::size_t>(std::clamp(rank, 1.0, count)) - 1];
}

Percentiles percentiles(std::vector<double> values) {
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  std::sort(values.begin(), values.end());
  return {percentile(values, 0.5), percentile(values, 0.99), percentile(values, 0.999), percentile(values, 1.0)};
}

double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}

}  // namespace thenar
