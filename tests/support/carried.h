// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include "engine/results/scene_run.h"
#include "engine/results/summary.h"

namespace thenar {

/// The run holds its object and brings it to where it was to go, within box_grasp's own limits: a tenth of a millimetre
/// at the end, over the last 0.3 s, and so much slip of each patch, for which 0.09 mm is its micro-slip.
inline void expect_carried(const Model& model, const RunSettings& settings, double most_slip_m = 0.09e-3) {
  State state(model);
  const Recording run = run_scene(model, state, settings);
  EXPECT_EQ(run.verdict.outcome, Outcome::kHeld) << in_words(run.verdict);
  ASSERT_FALSE(run.ticks.empty());
  Eigen::Vector3d off_m = Eigen::Vector3d::Zero();
  int ticks = 0;
  const double end_s = run.ticks.back().time_s;
  for (const TickRecord& tick : run.ticks) {
    if (!tick.is_from(end_s - kFinalWindow_s)) continue;
    off_m += tick.position_m - tick.target_m;
    ++ticks;
  }
  EXPECT_LT((off_m / ticks).norm(), 0.1e-3);
  for (const double slip_m : run.ticks.back().slip_m) EXPECT_LT(slip_m, most_slip_m);
  EXPECT_GT(run.ticks.back().target_m.norm(), 5e-3) << "it went somewhere";
}

}  // namespace thenar
