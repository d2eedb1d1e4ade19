// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "engine/models/build_model.h"
#include "engine/stiffness/object_stiffness.h"
#include "engine/stiffness/stiffness_range.h"
#include "engine/studies/model_parts.h"
#include "tests/support/scenes.h"

namespace thenar::chosen_stiffness_test {
namespace {

using Eigen::Vector3d;

std::string muscles(double translation_N_per_m, double rotation_Nm_per_rad, const std::string& more = "") {
  const auto all = [](double value, const std::string& unit) {
    const std::string one = std::to_string(value) + " " + unit;
    return "[" + one + ", " + one + ", " + one + "]";
  };
  return "control.muscles={stiffness: 23.4, object_stiffness: {translation: " + all(translation_N_per_m, "N/m") +
         ", rotation: " + all(rotation_Nm_per_rad, "N*m/rad") + "}" + more + "}";
}

struct Pushed {
  double effort_N, grip_N;      ///< Of all muscles; of the thumb.
  double predicted_m, moved_m;  ///< Along the push.
};

/// The box whose muscles stay as they are is pushed by 0.02 N until it rests. Postures that the object hardly holds
/// take b / kappa = 5 s for that.
Pushed push(const std::string& how) {
  const Model model = build_model(
      scene_of("box_cocontract", {kCoarseBox, how, "contact.tolerance=1e-8", "time.duration=32 s",
                                  "task.push={force: [0 N, 0.02 N, 0 N], from: 1.5 s, over: 40 s, rise: 50 ms}"}));
  GraspRun run(model);
  while (run.time_s() < 1.5 - 1e-9) run.tick();
  const PredictedStiffness predicted = predict_stiffness(run);
  const Vector3d before_m = run.state.X_WO.translation(), along = run.state.X_WO.linear().col(1);
  Pushed pushed{predicted.effort.sum_N, run.state.load[0].normal_N, 0.02 * Matrix6d(predicted.K_O.inverse())(1, 1),
                0.0};
  while (run.time_s() < model.scene.duration_s) run.tick();
  pushed.moved_m = along.dot(run.state.X_WO.translation() - before_m);
  return pushed;
}

// Muscles that pull against each other hold the box more stiffly at the same grip, by as much as their stiffness says:
// within 5 %, which is what a push of this size bends.
TEST(ChosenStiffness, CoContractionHoldsAgainstAPush) {
  const Pushed soft = push(muscles(70.0, 0.035, ", frozen_from: 0.9 s"));
  const Pushed stiff = push(muscles(250.0, 0.125, ", frozen_from: 0.9 s"));
  RecordProperty("soft_mm", std::to_string(1e3 * soft.moved_m));
  RecordProperty("stiff_mm", std::to_string(1e3 * stiff.moved_m));
  EXPECT_NEAR(soft.moved_m, soft.predicted_m, 0.05 * soft.predicted_m);
  EXPECT_NEAR(stiff.moved_m, stiff.predicted_m, 0.05 * stiff.predicted_m);
  EXPECT_NEAR(stiff.grip_N, soft.grip_N, 0.02 * soft.grip_N);
  EXPECT_GT(stiff.effort_N, 1.5 * soft.effort_N);
  EXPECT_LT(stiff.moved_m, 0.7 * soft.moved_m);
}

// The least forces that hold a squeeze do not hold it: the box turns away in the hand. Chosen for a stiffness, they do.
TEST(ChosenStiffness, ASqueezeBucklesWithTheLeastMuscleForces) {
  const auto outcome = [](const std::vector<std::string>& changes) {
    std::vector<std::string> all{kCoarseBox};
    all.insert(all.end(), changes.begin(), changes.end());
    const Model model = build_model(scene_of("squeeze_buckle", all));
    GraspRun run(model);
    while (run.time_s() < 1.0 - 1e-9) run.tick();
    const bool is_stable = predict_stiffness(run).is_stable();
    return std::pair(run_path(model).verdict.outcome, is_stable);
  };
  EXPECT_EQ(outcome({}), std::pair(Outcome::kLost, false));
  EXPECT_EQ(outcome({muscles(100.0, 0.05, ", frozen_from: 0.5 s")}), std::pair(Outcome::kHeld, true));
}

// What the laws choose is what they say: K_o of the choice is at least what was asked for, in every direction.
TEST(ChosenStiffness, IsHadInEveryDirection) {
  const Model model = build_model(scene_of("box_grasp", {kCoarseBox, muscles(150.0, 0.08), "time.duration=1 s"}));
  GraspRun run(model);
  int chosen = 0;
  while (run.time_s() < 1.0 - 1e-9) {
    run.tick();
    const StiffnessReport& report = run.report.stiffness;
    if (!(report.share > 0.0)) continue;
    ++chosen;
    Vector6d scale;
    scale << Vector3d::Ones(), Vector3d::Constant(1.0 / 0.025);
    Vector6d asked;
    asked << Vector3d::Constant(150.0), Vector3d::Constant(0.08);
    const Matrix6d had = report.K_O - Matrix6d((report.share * asked).asDiagonal());
    const Matrix6d rest = scale.asDiagonal() * had * scale.asDiagonal();
    ASSERT_GE(rest.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff(), -1e-6 * 150.0) << run.time_s();
  }
  EXPECT_GT(chosen, 900);
}

// More than the muscles have is told, and the rest goes on with what there is.
TEST(ChosenStiffness, ThatCannotBeHadIsToldInWords) {
  const Model model = build_model(scene_of("box_grasp", {kCoarseBox, muscles(900.0, 0.5), "time.duration=1 s"}));
  const PathRun run = run_path(model);
  EXPECT_EQ(run.verdict.outcome, Outcome::kOverLimits) << run.verdict.reason;
  EXPECT_NE(run.verdict.reason.find("no muscle forces make the object so stiff at 0.3"), std::string::npos)
      << run.verdict.reason;
  EXPECT_NE(run.verdict.reason.find(" of the object lacks "), std::string::npos) << run.verdict.reason;
}

// Also where excitations stay before the grip counts as built up: what was not had then is not had later.
TEST(ChosenStiffness, ThatWasNotHadWhenExcitationsFrozeIsTold) {
  const Model model = build_model(
      scene_of("box_grasp", {kCoarseBox, muscles(300.0, 0.16, ", frozen_from: 0.25 s"), "time.duration=0.5 s"}));
  const PathRun run = run_path(model);
  EXPECT_EQ(run.verdict.outcome, Outcome::kOverLimits) << run.verdict.reason;
  EXPECT_NE(run.verdict.reason.find("no muscle forces make the object so stiff at 0."), std::string::npos);
}

// Where pulps are what gives way, muscles alone cannot make the object stiffer, and a harder squeeze can: pulps grow
// stiffer under it. Where it does not help, as for turns, it is left alone.
TEST(ChosenStiffness, SqueezesSoftPulps) {
  const auto run = [](const std::string& squeeze, double translation_N_per_m, double rotation_Nm_per_rad) {
    std::string how = muscles(translation_N_per_m, rotation_Nm_per_rad);
    how.insert(how.size() - 2, squeeze);
    const Model model = build_model(
        scene_of("box_stiff", {kCoarseBox, how, "task={}", "fingertips.reduced_modulus=0.06 MPa",
                               "fingertips.stiffening=0.5 1/N", "contact.max_per_finger=60", "time.duration=1.5 s"}));
    GraspRun grasp(model);
    while (grasp.time_s() < 1.5 - 1e-9) grasp.tick();
    return grasp.report.stiffness;
  };
  const StiffnessReport alone = run("", 850.0, 0.02), squeezed = run(", squeeze: 10 N", 850.0, 0.02),
                        turned = run(", squeeze: 10 N", 100.0, 0.04);
  EXPECT_LT(alone.share, 0.97);
  EXPECT_EQ(squeezed.share, 1.0);
  EXPECT_GT(squeezed.squeeze_N, 1.0);
  EXPECT_LT(turned.squeeze_N, 0.1);
}

// Where a finger's posture gives way, less stiffness of the object does not help, and is not tried: a period takes the
// iterations of one solve. Those of another moment may be a few more; four solves take four times as many.
TEST(ChosenStiffness, ThatAPostureRulesOutIsTriedOnce) {
  std::string how = muscles(20.0, 0.01);
  how.replace(how.find("23.4"), 4, "1");  // Fibres that are so soft hold no finger.
  const Model model = build_model(scene_of("box_stiff", {kCoarseBox, how, "task={}"}));
  GraspRun run(model);
  while (run.time_s() < 0.5 - 1e-9) run.tick();
  const StiffGrasp grasp(run);
  StiffMuscleData asked = grasp.problem;
  asked.K_des = grasp.K_scene;
  Eigen::VectorXd f(asked.limit.size());
  const StiffMuscleReport once = solve_stiff_muscles(asked, f);
  ASSERT_EQ(once.cause, StiffCause::kPosture);
  run.tick();
  const StiffnessReport& report = run.report.stiffness;
  EXPECT_TRUE(report.is_infeasible && !report.axis_O);
  EXPECT_EQ(report.share, 0.0);
  EXPECT_LT(report.iterations, 2 * once.iterations);
}

// What docs/guide/stiffness.md warns of: pulps that are far too soft for what is asked for are pressed in beyond
// Hertz's law, by which a squeeze foretells how they grow stiffer. Squeezed for it the box is lost, within a second;
// without, the grip keeps half of what is asked for or more.
TEST(ChosenStiffness, ASqueezeOfPulpsThatAreFarTooSoftLosesTheObject) {
  const auto box = [](const std::string& squeeze) {
    std::string how = muscles(500.0, 0.02, ", activation: 10 ms, deactivation: 40 ms");
    how.insert(how.find('}'), squeeze);
    return build_model(scene_of("box_stiff", {kCoarseBox, how, "task={}", "fingertips.reduced_modulus=0.03 MPa",
                                              "contact.max_per_finger=60", "time.duration=1 s"}));
  };
  EXPECT_EQ(run_path(box(", squeeze: 3 N")).verdict.outcome, Outcome::kLost);
  const Model alone = box("");
  GraspRun run(alone);
  double least = 1.0;
  while (run.time_s() < 1.0 - 1e-9) {
    run.tick();
    if (run.time_s() > 0.3) least = std::min(least, run.report.stiffness.share);
  }
  EXPECT_GT(least, 0.5);
}

// Where not all can be had, the grip keeps as much as there is: period by period, as near as its tries are, and not the
// least forces between.
TEST(ChosenStiffness, ThatCannotBeHadIsHadAsFarAsThereIs) {
  const Model model = build_model(scene_of("box_grasp", {kCoarseBox, muscles(400.0, 0.2), "time.duration=2.5 s"}));
  GraspRun run(model);
  while (run.time_s() < 1.5 - 1e-9) run.tick();  // What there is grows until the box is at rest.
  double least = 1.0, most = 0.0;
  int lacked = 0;
  while (run.time_s() < 2.5 - 1e-9) {
    run.tick();
    const StiffnessReport& report = run.report.stiffness;
    least = std::min(least, report.share);
    most = std::max(most, report.share);
    if (!report.is_infeasible || !report.axis_O) continue;
    ++lacked;
    // Of all that was asked for: what is left of it beyond the share, at the least.
    EXPECT_GT(report.lacking, 0.9 * (1.0 - most) * (report.rotates ? 0.2 : 400.0)) << run.time_s();
  }
  EXPECT_LT(most, 0.95);
  EXPECT_GT(least, 0.8 * most);
  EXPECT_GT(lacked, 1);
}

}  // namespace
}  // namespace thenar::chosen_stiffness_test
