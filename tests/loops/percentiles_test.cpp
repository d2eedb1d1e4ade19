// SPDX-License-Identifier: Apache-2.0
#include "engine/loops/percentiles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "tests/support/scenes.h"

namespace thenar::percentiles_test {
namespace {

// The definition, by counting: the smallest value that at least the share q of the sample does not exceed.
double percentile_by_counting(const std::vector<double>& values, double q) {
  double best = std::numeric_limits<double>::infinity();
  for (const double candidate : values) {
    const auto below = std::count_if(values.begin(), values.end(), [&](double v) { return v <= candidate; });
    const bool enough = static_cast<double>(below) >= q * static_cast<double>(values.size()) - 1e-6;
    if (enough) best = std::min(best, candidate);
  }
  return best;
}

TEST(Percentiles, AreTheValuesFoundByCounting) {
  std::mt19937_64 random(3);
  for (const int n : {1, 2, 3, 10, 99, 100, 101, 999, 1000, 1001}) {
    std::vector<double> values(n);
    for (double& v : values) v = std::floor(uniform(random, 0.0, 50.0));  // with ties
    const Percentiles p = percentiles(values);
    EXPECT_EQ(p.p50, percentile_by_counting(values, 0.5)) << n;
    EXPECT_EQ(p.p99, percentile_by_counting(values, 0.99)) << n;
    EXPECT_EQ(p.p999, percentile_by_counting(values, 0.999)) << n;
    EXPECT_EQ(p.max, *std::max_element(values.begin(), values.end())) << n;
  }
}

TEST(Percentiles, OfNothingAreNaN) {
  EXPECT_TRUE(std::isnan(percentiles({}).p50));
  EXPECT_TRUE(std::isnan(percentiles({std::nan("")}).max));
}

}  // namespace
}  // namespace thenar::percentiles_test
