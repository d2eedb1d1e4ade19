// SPDX-License-Identifier: Apache-2.0
#include "engine/environment/minimum_jerk.h"

#include <gtest/gtest.h>

namespace thenar::minimum_jerk_test {
namespace {

TEST(MinimumJerk, BeginsAndEndsAtRest) {
  for (const double before : {-1.0, 0.0}) EXPECT_EQ(minimum_jerk(before), 0.0);
  for (const double after : {1.0, 7.0}) EXPECT_EQ(minimum_jerk(after), 1.0);
  for (const double still : {-1.0, 0.0, 1.0, 7.0}) EXPECT_EQ(minimum_jerk_rate(still), 0.0);
  EXPECT_EQ(minimum_jerk(0.5), 0.5);
  EXPECT_EQ(minimum_jerk_rate(0.5), kMinimumJerkPeak);
}

// Central differences are off by h^2 / 6 times the third derivative, of at most 60: 1e-9 here; rounding adds 1e-16 / h.
TEST(MinimumJerk, HasTheRateThatItSays) {
  constexpr double h = 1e-5;
  for (double s = 0.05; s < 1.0; s += 0.05) {
    EXPECT_NEAR((minimum_jerk(s + h) - minimum_jerk(s - h)) / (2.0 * h), minimum_jerk_rate(s), 2e-9) << s;
    EXPECT_LE(minimum_jerk_rate(s), kMinimumJerkPeak);
  }
}

}  // namespace
}  // namespace thenar::minimum_jerk_test
