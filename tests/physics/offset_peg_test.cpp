// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <variant>

#include "engine/models/build_model.h"
#include "engine/results/scene_run.h"
#include "tests/support/scenes.h"

// The peg of peg_assembly, where the arm stops off the hole: chamfer and clearance take 1.05 mm.

namespace thenar::offset_peg_test {
namespace {

using Eigen::Vector3d;

struct Peg {
  Peg(double offset_mm, double direction_deg)
      : model(build_model(
            scene_of("peg_assembly",
                     {"task.phases[3].move.by=[" + std::to_string(offset_mm * std::cos(direction_deg * kRadian)) +
                          " mm, " + std::to_string(40.0 + offset_mm * std::sin(direction_deg * kRadian)) + " mm, 0 mm]",
                      "object.points=9000"}))),
        state(model),
        recording(run_scene(model, state, RunSettings{})) {}

  /// Where its tip is in the hole.
  [[nodiscard]] Vector3d tip_m() const {
    const EnvironmentBody& plate = model.scene.environment->bodies.front();
    const double half_m = 0.5 * std::get<CylinderShape>(model.scene.object.shape).length_m;
    const double time_s = recording.ticks.back().time_s;
    const Eigen::Isometry3d X_WE = pose(plate, {time_s, arm_m(state.arm, time_s)});
    return X_WE.inverse() * (state.X_WO * Vector3d(0.0, 0.0, -half_m));
  }

  static constexpr double kRadian = std::numbers::pi / 180.0;
  Model model;
  State state;
  Recording recording;
};

// Where the index has to push a round side on by friction alone, three points hold little: what the chamfer pushes with
// makes them squeeze five times as much. There a jump of the commands, or a list of contacts that is too short for the
// squeeze, shows: the peg goes in without energy from nowhere, and within the muscles' limits. Forces: no more than
// half again of what an insertion may take, 5 N. The ledger's error is some 1e-13 of its terms.
TEST(OffsetPeg, GoesInFromEachSide) {
  for (const auto& [offset_mm, direction_deg] :
       {std::pair(0.5, 270.0), std::pair(0.75, 210.0), std::pair(0.75, 60.0)}) {
    SCOPED_TRACE(std::to_string(offset_mm) + " mm at " + std::to_string(direction_deg));
    const Peg peg(offset_mm, direction_deg);
    EXPECT_EQ(peg.recording.verdict.outcome, Outcome::kTaskDone) << in_words(peg.recording.verdict);
    Ledger all;
    for (const TickRecord& tick : peg.recording.ticks) {
      all.add(tick.contact.ledger);
      EXPECT_LT(tick.contact.environment.normal_N, 5.0);
      for (const NormalTangential& force : tick.force) EXPECT_LT(force.normal_N, 7.5) << tick.time_s;
    }
    EXPECT_LT(all.injected_J, 1e-3 * all.drive_J);
    EXPECT_NEAR(peg.tip_m().z(), -std::get<HoleShape>(peg.model.scene.environment->bodies.front().shape).depth_m, 1e-4)
        << "on the floor";
    EXPECT_LT(peg.tip_m().head<2>().norm(), 60e-6) << "half of the clearance, and what the tilt makes of it";
  }
}

// Where another phase begins, nothing has changed at the peg: what the fingers are asked for goes on. 0.02 N is more
// than the sum of a tick's changes while the arm is under way.
TEST(OffsetPeg, OtherGainsAskForTheSameForces) {
  const Peg peg(0.5, 270.0);
  const auto& ticks = peg.recording.ticks;
  int begun = 0;
  for (std::size_t i = 1; i < ticks.size(); ++i) {
    if (ticks[i].phase == ticks[i - 1].phase || ticks[i].phase < 2 || ticks[i].phase > 5) continue;
    ++begun;
    for (int k = 0; k < peg.model.fingers(); ++k) {
      EXPECT_LT((ticks[i].desired_N[k] - ticks[i - 1].desired_N[k]).norm(), 0.02) << ticks[i].phase << " " << k;
    }
  }
  EXPECT_EQ(begun, 4) << "lift, move, insert, place";
}

}  // namespace
}  // namespace thenar::offset_peg_test
