// SPDX-License-Identifier: Apache-2.0
#include "engine/studies/savings.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "engine/models/build_model.h"
#include "engine/studies/model_parts.h"
#include "tests/support/scenes.h"

namespace thenar::savings_test {
namespace {

// Of 6 differences all lie on one side of the median by 2 / 2^6 = 3.1 %; of 9 all but one do by 3.9 %, of 15 all but
// three by 3.5 %: one value fewer would be above 5 %.
TEST(Savings, AnIntervalHoldsTheMedianWith95Percent) {
  const Saving six = saving_of({6, 1, 5, 2, 4, 3});
  EXPECT_EQ(six.us, 3);
  EXPECT_EQ(six.low_us, 1);
  EXPECT_EQ(six.high_us, 6);
  const Saving nine = saving_of({1, 2, 3, 4, 5, 6, 7, 8, 900});
  EXPECT_EQ(nine.us, 5);
  EXPECT_EQ(nine.low_us, 2);
  EXPECT_EQ(nine.high_us, 8);

  std::mt19937 bits(1);
  std::lognormal_distribution<double> skewed(0.0, 1.0);  // of median 1
  int held = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    std::vector<double> differences(15);
    for (double& d : differences) d = skewed(bits);
    const Saving saving = saving_of(differences);
    held += saving.low_us <= 1.0 && 1.0 <= saving.high_us ? 1 : 0;
  }
  // 96.5 %, give or take three times sqrt(0.035 * 0.965 / 2000) = 0.4 %.
  EXPECT_GT(held, 0.952 * 2000);
  EXPECT_LT(held, 0.978 * 2000);
}

// What costs most shows, also on a busy machine; nothing left out saves nothing.
TEST(Savings, RunsInTurns) {
  const Model full = build_model(scene_of("box_grasp", {kCoarseBox, "time.duration=60 ms"}));
  int runs = 0;
  const Savings savings = measure_savings(full, {build_model(leave_out(full.scene, Part::kFingertips), full), full},
                                          [&](const std::string&) { ++runs; });
  EXPECT_EQ(savings.turns, runs);
  EXPECT_GE(savings.turns, 6);
  ASSERT_EQ(savings.without.size(), 2U);
  EXPECT_GT(savings.without[0].us, 0.0);
  EXPECT_LE(savings.without[1].low_us, savings.without[1].us);
  EXPECT_LT(savings.without[1].us, savings.without[0].us);
}

}  // namespace
}  // namespace thenar::savings_test
