// SPDX-License-Identifier: Apache-2.0
#include "engine/loops/known_stiffness.h"

#include <gtest/gtest.h>

#include <cmath>

#include "engine/models/build_model.h"
#include "tests/support/scenes.h"

namespace thenar::known_stiffness_test {
namespace {

using Eigen::Vector3d;

// A period without an answer hides neither the last stiffness nor, later, what was lacking.
TEST(KnownStiffness, RemembersTheLastOfEachKind) {
  const Scene scene = scene_of("box_stiff", {kCoarseBox});
  const auto period = [&](bool chosen, bool infeasible, double share) {
    ControlReport report(scene.hand);
    report.stiffness.is_chosen = chosen;
    report.stiffness.is_infeasible = infeasible;
    report.stiffness.share = share;
    return KnownStiffness::of(scene, report);
  };
  KnownStiffness known;
  KnownStiffness first = period(false, false, 0.0), second = period(true, false, 0.9), third = period(true, true, 0.0),
                 fourth = period(true, false, 0.7);
  known.add(0.1, first);
  EXPECT_FALSE(first.chosen || first.lacked);
  known.add(0.2, second);
  EXPECT_EQ(second.chosen, second.now);
  known.add(0.3, third);
  EXPECT_EQ(third.chosen->report.share, 0.9);
  EXPECT_EQ(third.lacked, third.now);
  known.add(0.4, fourth);
  EXPECT_EQ(fourth.chosen->report.share, 0.7);
  EXPECT_EQ(fourth.lacked, third.now);
  EXPECT_EQ(fourth.lacked_s, 0.3);
  Scene none = scene;
  none.control->muscles->object_stiffness.reset();
  EXPECT_FALSE(KnownStiffness::of(none, ControlReport(scene.hand)).now);
}

// Along an axis or about one, with its muscles.
TEST(KnownStiffness, ShowsWhatLacks) {
  const Model model = build_model(scene_of("box_stiff", {kCoarseBox}));
  Snapshot state;
  state.q = model.scene.posture;
  for (const bool rotates : {false, true}) {
    ControlReport report(model.scene.hand);
    report.stiffness.is_chosen = report.stiffness.is_infeasible = true;
    report.stiffness.axis_O = Vector3d(0.6, 0.0, 0.8);
    report.stiffness.rotates = rotates;
    report.stiffness.lacking = 0.01;
    report.stiffness.at_limit = 0b101;
    KnownStiffness now = KnownStiffness::of(model.scene, report), known;
    known.add(0.7, now);
    const ShownStiffness shown = shown_stiffness(model, state, known);
    EXPECT_EQ(rotates ? shown.lack_Nm_per_rad : shown.lack_N_per_m, 0.01);
    EXPECT_TRUE(std::isnan(rotates ? shown.lack_N_per_m : shown.lack_Nm_per_rad));
    EXPECT_EQ(shown.at_limit.head<3>(), Vector3d(1.0, 0.0, 1.0));
    EXPECT_EQ(shown.at_limit.sum(), 2.0);
    EXPECT_TRUE(std::isnan(shown.along_N_per_m(0, 0)));
  }
}

// As the report has it.
TEST(KnownStiffness, IsShown) {
  const Model model = build_model(scene_of("box_stiff", {kCoarseBox}));
  Snapshot state;
  state.q = model.scene.posture;
  ControlReport report(model.scene.hand);
  report.stiffness.is_chosen = true;
  report.stiffness.share = 1.0;
  report.stiffness.K_O.diagonal() << 100.0, 250.0, 900.0, 0.1, 0.2, 0.4;
  KnownStiffness now = KnownStiffness::of(model.scene, report), known;
  known.add(0.0, now);
  const ShownStiffness shown = shown_stiffness(model, state, known);
  EXPECT_EQ(shown.along_N_per_m.diagonal(), Vector3d(100.0, 250.0, 900.0));
  EXPECT_EQ(shown.about_Nm_per_rad.diagonal(), Vector3d(0.1, 0.2, 0.4));
  EXPECT_TRUE(std::isnan(shown.lack_s));
  // No torques, no forces.
  EXPECT_LT(shown.least_N.norm(), 1e-9);
}

}  // namespace
}  // namespace thenar::known_stiffness_test
