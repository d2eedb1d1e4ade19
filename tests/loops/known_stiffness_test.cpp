#include "engine/loops/known_stiffness.h"

#include <gtest/gtest.h>

#include <cmath>

#include "engine/scenes/build_model.h"
#include "tests/support/scenes.h"

namespace thenar::known_stiffness_test {
namespace {

using Eigen::Matrix3d;
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
  KnownStiffness first = period(false, false, 1.0), second = period(true, false, 0.9), third = period(true, true, 0.8),
                 fourth = period(true, false, 0.7);
  known.add(0.1, first);
  EXPECT_FALSE(first.chosen || first.lacked);
  known.add(0.2, second);
  EXPECT_EQ(second.chosen, second.now);
  known.add(0.3, third);
  EXPECT_EQ(third.chosen->report.share, 0.9);
  EXPECT_EQ(third.lacked->report.share, 0.8);
  known.add(0.4, fourth);
  EXPECT_EQ(fourth.chosen->report.share, 0.7);
  EXPECT_EQ(fourth.lacked->report.share, 0.8);
  EXPECT_EQ(fourth.lacked_s, 0.3);
  Scene none = scene;
  none.control->muscles->object_stiffness.reset();
  EXPECT_FALSE(KnownStiffness::of(none, ControlReport(scene.hand)).now);
}

// The solver says what a share of the stiffness lacks; the rest of it lacks as a whole: a' K a about a.
TEST(KnownStiffness, LacksOfAllThatIsAskedFor) {
  Model model = build_model(scene_of("box_stiff", {kCoarseBox}));
  ObjectStiffness& asked = *model.scene.control->muscles->object_stiffness;
  asked.translation_N_per_m = {100.0, 200.0, 400.0};
  asked.rotation_Nm_per_rad = {0.1, 0.2, 0.4};
  Snapshot state;
  state.q = model.scene.posture;
  for (const bool rotates : {false, true}) {
    ControlReport report(model.scene.hand);
    report.stiffness.is_chosen = report.stiffness.is_infeasible = true;
    report.stiffness.axis_O = Vector3d(0.6, 0.0, 0.8);
    report.stiffness.rotates = rotates;
    report.stiffness.lacking = 0.01;
    report.stiffness.share = 0.5;
    report.stiffness.at_limit = 0b101;
    KnownStiffness now = KnownStiffness::of(model.scene, report), known;
    known.add(0.7, now);
    const ShownStiffness shown = shown_stiffness(model, state, known);
    const double along = 0.01 + 0.5 * (0.36 * 100.0 + 0.64 * 400.0), about = 0.01 + 0.5 * (0.36 * 0.1 + 0.64 * 0.4);
    EXPECT_NEAR(rotates ? shown.lack_Nm_per_rad : shown.lack_N_per_m, rotates ? about : along, 1e-12 * along);
    EXPECT_TRUE(std::isnan(rotates ? shown.lack_N_per_m : shown.lack_Nm_per_rad));
    EXPECT_EQ(shown.at_limit.head<3>(), Vector3d(1.0, 0.0, 1.0));
    EXPECT_EQ(shown.at_limit.sum(), 2.0);
    EXPECT_TRUE(std::isnan(shown.along_N_per_m(0, 0)));
  }
}

// Springs k_i that hold the object at the point that the scene names, along and about axes of the object: whatever the
// pose, these come back, to rounding of numbers of 1e3 on arms of 0.1 m.
TEST(KnownStiffness, IsShownAboutTheScenesPointInTheObjectsAxes) {
  Model model = build_model(scene_of("box_stiff", {kCoarseBox}));
  ObjectStiffness& asked = *model.scene.control->muscles->object_stiffness;
  asked = {{100.0, 250.0, 900.0}, {0.1, 0.2, 0.4}, {0.01, -0.02, 0.03}};
  std::mt19937_64 random(20);
  for (int i = 0; i < 20; ++i) {
    Snapshot state;
    state.q = model.scene.posture;
    state.X_WO = random_rotation_about(Vector3d(0.1, 0.0, 0.05), random);
    ControlReport report(model.scene.hand);
    report.stiffness.is_chosen = true;
    report.stiffness.K_object = wanted_stiffness(asked, state.X_WO);
    KnownStiffness now = KnownStiffness::of(model.scene, report), known;
    known.add(0.0, now);
    const ShownStiffness shown = shown_stiffness(model, state, known);
    EXPECT_LT((shown.along_N_per_m - Matrix3d(asked.translation_N_per_m.asDiagonal())).norm(), 1e-9);
    EXPECT_LT((shown.about_Nm_per_rad - Matrix3d(asked.rotation_Nm_per_rad.asDiagonal())).norm(), 1e-9);
    EXPECT_TRUE(std::isnan(shown.lack_s));
    // No torques, no forces.
    EXPECT_LT(shown.least_N.norm(), 1e-9);
  }
}

}  // namespace
}  // namespace thenar::known_stiffness_test
