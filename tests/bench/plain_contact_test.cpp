// SPDX-License-Identifier: Apache-2.0
#include "bench/methods/plain_contact.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "bench/report/outcome_map.h"
#include "engine/models/build_model.h"
#include "engine/results/scene_run.h"
#include "tests/support/scenes.h"

namespace thenar::plain_contact_test {
namespace {

Model short_grasp(std::vector<std::string> overrides, const std::string& duration = "0.6 s") {
  overrides.insert(overrides.end(), {kCoarseBox, "time.duration=" + duration});
  return build_model(scene_of("box_grasp", overrides));
}

std::vector<std::string> step_ms(double ms) {
  return {fmt::format("time.step={} ms", ms), fmt::format("time.control_period={} ms", ms)};
}

Recording ours(const Model& model) {
  State state(model);
  return run_scene(model, state);
}

Recording ours_in_lockstep(const Model& model) {
  State state(model);
  return run_scene(model, state, {.lockstep = LockstepSettings{}});
}

Outcome outcome(const Model& model, const PlainContact& plain) {
  return run_and_judge(model, [&](const Model& m) { return run_plain(m, plain); }).outcome;
}

double end_error_m(const Recording& run) { return (run.ticks.back().position_m - run.ticks.back().target_m).norm(); }

// Where its springs are stable, the penalty is another model of the same grasp: the loop is fair, and the box goes
// where ours goes. The target's path is the same, so what differs is the pulps' give: a tenth of their depth of a
// millimetre.
TEST(PlainContact, PenaltyHoldsTheBoxAsOursInSmallSteps) {
  const Model model = short_grasp(step_ms(0.5));
  const Recording penalty = run_plain(model, {});
  EXPECT_LE(penalty.verdict.outcome, Outcome::kOverLimits) << penalty.verdict.reason;
  EXPECT_NEAR(end_error_m(penalty), end_error_m(ours(model)), 0.1e-3);
}

// A linear system's limit is sharp: a step of half of it settles. Beyond it an oscillation grows until contacts open,
// and pressed points are fewer then: a step of twice the limit is beyond that of half as many springs.
TEST(PlainContact, PenaltyFailsBeyondItsLimitAndOursHolds) {
  const double limit_ms = 1e3 * penalty_step_limit(short_grasp({}), 0.2e-3, 0.2)(short_grasp({}).scene);
  const Model below = short_grasp(step_ms(0.5 * limit_ms)), beyond = short_grasp(step_ms(2.0 * limit_ms));
  EXPECT_LE(outcome(below, {}), Outcome::kOverLimits);
  EXPECT_GE(outcome(beyond, {}), Outcome::kUnstable);
  EXPECT_EQ(run_and_judge(beyond, ours).outcome, Outcome::kHeld);
}

TEST(PlainContact, PenaltyLimitIsProportionalToViscosity) {
  const Model model = short_grasp({});
  const auto limit_s = penalty_step_limit(model, 0.2e-3, 0.2);
  Scene twice = model.scene;
  twice.joint_viscosity *= 2.0;
  twice.object.translation_damping *= 2.0;
  twice.object.rotation_damping *= 2.0;
  EXPECT_NEAR(limit_s(twice) / limit_s(model.scene), 2.0, 1e-9);
}

TEST(PlainContact, WOfTheWrongStepLosesTheBox) {
  const Model model = short_grasp({});
  EXPECT_EQ(outcome(model, {ContactLaw::kWrongStep, model.scene.step_s}), Outcome::kHeld);
  const Recording lost = run_plain(model, {ContactLaw::kWrongStep, 5e-3});
  EXPECT_GE(lost.verdict.outcome, Outcome::kLost) << lost.verdict.reason;
}

// What fails there is the wrong step alone: the same code with the right one holds where control is as slow.
TEST(PlainContact, WOfTheRightStepHoldsWithSlowControl) {
  const Model model = short_grasp({"time.control_period=20 ms"});
  EXPECT_EQ(outcome(model, {ContactLaw::kWrongStep, model.scene.step_s}), Outcome::kHeld);
  EXPECT_NE(outcome(model, {ContactLaw::kWrongStep, model.scene.control_period_s}), Outcome::kHeld);
}

// With forces far inside the cones all solvers have the same problem, which has one solution.
TEST(PlainContact, SolversAgreeWhereNothingSlides) {
  const Model model = short_grasp({}, "0.3 s");
  const Recording reference = ours(model);
  for (const PlainContact plain :
       {PlainContact{ContactLaw::kPlainSweeps}, PlainContact{ContactLaw::kWrongStep, 1e-3}}) {
    const Recording run = run_plain(model, plain);
    // Each tick is solved to 1e-6, and sticking keeps what ticks leave: 300 of them.
    EXPECT_LT((run.ticks.back().position_m - reference.ticks.back().position_m).norm(), 1e-6);
  }
}

TEST(Gain, BeyondItsLimitLosesTheBoxAndBelowHoldsIt) {
  // K = 2 b / T_c = 20 at 5 ms; the pulp is softer than the controller's model of it, and its filter lags: a factor of
  // two.
  EXPECT_EQ(run_and_judge(short_grasp({"time.control_period=5 ms", "control.gain=10 N*m/rad"}), ours).outcome,
            Outcome::kHeld);
  EXPECT_GE(run_and_judge(short_grasp({"time.control_period=5 ms", "control.gain=60 N*m/rad"}), ours).outcome,
            Outcome::kUnstable);
}

// Scenes far out in every direction: whatever becomes of them, it is said, by both runners; run_and_judge throws where
// not.
TEST(HarshScenes, NeverFailSilently) {
  const std::vector<std::vector<std::string>> scenes = {
      {"time.step=20 ms", "time.control_period=20 ms", "fingertips.reduced_modulus=10 MPa"},
      {"time.step=20 ms", "time.control_period=20 ms", "fingertips.reduced_modulus=0.005 MPa"},
      {"contact.friction=0.01", "control.grasp.friction=0.009", "control.grasp.internal_force=30 N"},
      {"contact.friction=10", "control.grasp.friction=10", "control.grasp.internal_force=0 N"},
      {"hand.joint_viscosity=0.00005 N*m*s"},
      {"hand.joint_viscosity=50 N*m*s", "object.damping.translation=0.01 N*s/m"},
      {"hand.joint_viscosity=0.0005 N*m*s", "object.damping.translation=10000 N*s/m"},
      {"object.damping.translation=0.001 N*s/m", "object.damping.rotation=0.0000005 N*m*s"},
      {"control.gain=100000 N*m/rad"},
      {"control.position.p=100000 N/m", "control.position.i=0 N/(m*s)"},
      {"time.control_period=20 ms", "time.control_delay=100 ms"},
      {"time.control_period=50 ms", "task.translate.over=0.01 s"},
      {"contact.max_per_finger=1"},
      {"contact.max_sweeps=1"},
      {"contact.tolerance=1"},
      {"object.mass=10 kg"},
      {"fingertips.leaves=8"},
      {"fingertips.kernel=gaussian", "fingertips.leaves=1200", "contact.max_per_finger=60"}};
  for (const auto& overrides : scenes) {
    const Model model = short_grasp(overrides, "0.5 s");
    EXPECT_NO_THROW((void)run_and_judge(model, ours)) << overrides.front();
    EXPECT_NO_THROW((void)run_and_judge(model, ours_in_lockstep)) << overrides.front();
  }
}

}  // namespace
}  // namespace thenar::plain_contact_test
