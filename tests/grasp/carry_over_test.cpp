// SPDX-License-Identifier: Apache-2.0
#include "engine/grasp/carry_over.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>

#include "engine/loops/run.h"
#include "engine/loops/split_grasp.h"
#include "engine/models/build_model.h"
#include "engine/models/surface_model.h"
#include "tests/support/scenes.h"
#include "tests/support/split_runs.h"
#include "tests/support/three_fingers.h"

namespace thenar::carry_over_test {
namespace {

using namespace split_runs;

// What the environment is sheared by goes on, too: else a box on a slope would slip at each change.
TEST(CarryOver, KeepsTheForcesOfTheEnvironment) {
  const Model model = build_model(scene_of("resting_box"));
  GraspRun run(model);
  while (run.time_s() < 0.1) run.tick();
  const State carried = carry_over(model, run.state, model);
  ASSERT_EQ(carried.environment_forces.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(carried.environment_forces[i].f_E, run.state.environment_forces[i].f_E);
}

/// Other fingertips or another step for a running grasp.
struct Change {
  const char* name;
  PulpKernel kernel;
  int level;
  double step_s;
};

class ChangedGrasp : public testing::TestWithParam<Change> {};

// Time, pose and grip go on, and the box stays where it is held.
TEST_P(ChangedGrasp, HoldsTheBox) {
  Scene scene = split_scene();
  scene.task = {};
  Model model = build_model(scene);
  auto grasp = std::make_unique<SplitGrasp>(model);
  run(*grasp, 500);
  const State before = grasp->state();
  const std::int64_t sequence = grasp->controller().sequence;
  const Model old = model;
  model.scene.step_s = GetParam().step_s;
  set_fingertips(model, GetParam().kernel, GetParam().level);
  grasp = std::make_unique<SplitGrasp>(model, old, *grasp);
  EXPECT_EQ(grasp->first_control().grasp, GraspStatus::kOptimal);
  EXPECT_EQ(grasp->controller().sequence, sequence + 1);
  EXPECT_NEAR(static_cast<double>(grasp->state().tick) * model.scene.step_s, 0.5, 1e-9);
  EXPECT_EQ(grasp->state().q, before.q);

  double way_m = 0.0, force_N = 0.0;
  const auto end = static_cast<std::int64_t>(std::lround(1.0 / model.scene.step_s));
  while (grasp->state().tick < end) {
    run(*grasp, grasp->state().tick + 1);
    way_m = std::max(way_m, (grasp->state().X_WO.translation() - before.X_WO.translation()).norm());
    force_N = std::max(force_N, grasp->state().load[0].force_N.norm());
    ASSERT_TRUE(is_finite(grasp->state()));
    ASSERT_FALSE(grasp->state().held);
  }
  // A pulp with other control points is pressed in otherwise: by some of the depth of the press, 1 mm.
  EXPECT_LT(way_m, 0.25e-3);
  EXPECT_LT(force_N, 1.5 * before.load[0].force_N.norm());
  EXPECT_LT((model.target(1.0).translation() - grasp->state().X_WO.translation()).norm(), 0.1e-3);
  for (int k = 0; k < kFingers; ++k) {
    EXPECT_NEAR(grasp->state().load[k].normal_N, before.load[k].normal_N, 0.1 * before.load[k].normal_N) << k;
  }
}

// What the grasp before kept had room for few contacts; now there are more.
TEST(SplitGrasp, GoesOnWithMoreContacts) {
  Model model = build_model(split_scene());
  set_fingertips(model, PulpKernel::kBoussinesq, 5);
  const auto few = model.max_contacts;
  auto grasp = std::make_unique<SplitGrasp>(model);
  run(*grasp, 500);
  const Model old = model;
  set_fingertips(model, PulpKernel::kBoussinesq, 0);
  grasp = std::make_unique<SplitGrasp>(model, old, *grasp);
  run(*grasp, 700);
  ASSERT_GT(std::ssize(grasp->state().forces), few);
  EXPECT_TRUE(is_finite(grasp->state()));
}

INSTANTIATE_TEST_SUITE_P(SplitGrasp, ChangedGrasp,
                         testing::Values(Change{"Nothing", PulpKernel::kBoussinesq, 0, 1e-3},
                                         Change{"Coarse", PulpKernel::kBoussinesq, 2, 1e-3},
                                         Change{"Gaussian", PulpKernel::kGaussian, 0, 1e-3},
                                         Change{"CoarseGaussian", PulpKernel::kGaussian, 3, 1e-3},
                                         Change{"FasterContact", PulpKernel::kBoussinesq, 0, 0.25e-3},
                                         Change{"SlowerContact", PulpKernel::kBoussinesq, 0, 5e-3}),
                         [](const auto& change) { return std::string(change.param.name); });

TEST(SplitGrasp, GoesOnAsItWasWhereNothingHasChanged) {
  const Model model = build_model(split_scene());
  SplitGrasp grasp(model), same(model);
  run(grasp, 150);
  run(same, 150);
  grasp.heed_scene();
  grasp.hold_frames_back(0);
  run(grasp, 300);
  run(same, 300);
  EXPECT_EQ(grasp.state().q, same.state().q);
  EXPECT_EQ(grasp.state().X_WO.matrix(), same.state().X_WO.matrix());
  EXPECT_EQ(grasp.controller().f_desired, same.controller().f_desired);

  // Nor does a state carried over to an equal model change.
  const State carried = carry_over(model, grasp.state(), Model(model));
  EXPECT_EQ(carried.tick, 300);
  EXPECT_EQ(carried.u_m, grasp.state().u_m);
  ASSERT_EQ(carried.forces.size(), grasp.state().forces.size());
  for (std::size_t i = 0; i < carried.forces.size(); ++i) {
    EXPECT_EQ(carried.forces[i].control_point, grasp.state().forces[i].control_point);
    EXPECT_EQ(carried.forces[i].f_C, grasp.state().forces[i].f_C);
  }
  for (int k = 0; k < kFingers; ++k) EXPECT_EQ(carried.load[k].force_N, grasp.state().load[k].force_N);
}

// What a model's frames can hold decides how many contact forces its snapshots have room for.
TEST(CarryOver, OfAChosenStiffnessHasTheRoomOfItsModel) {
  const Model from = build_model(scene_of("box_stiff", {kCoarseBox, "contact.max_per_finger=8"}));
  const Model to = build_model(scene_of("box_stiff", {kCoarseBox}));
  ASSERT_LT(from.max_contacts, to.max_contacts);
  const State carried = carry_over(from, State(from), to), back = carry_over(to, State(to), from);
  EXPECT_EQ(std::ssize(carried.contact_forces), to.max_contacts);
  EXPECT_EQ(std::ssize(back.contact_forces), from.max_contacts);
  const Model plain = build_model(scene_of("box_grasp", {kCoarseBox}));
  EXPECT_TRUE(carry_over(from, State(from), plain).contact_forces.empty());
}

}  // namespace
}  // namespace thenar::carry_over_test
