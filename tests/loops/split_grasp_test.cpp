#include "engine/loops/split_grasp.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>

#include "engine/grasp/carry_over.h"
#include "engine/loops/run.h"
#include "engine/scenes/build_model.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/scenes.h"

namespace thenar::split_grasp_test {
namespace {

// The exchange adds nothing to the two ticks: the same calls in the same order, on a frame and a snapshot handed over
// by hand, give the same bits; so a draft's old contents do not leak into a frame either.
TEST(SplitGrasp, IsTheTwoTicksAndAnExchange) {
  const Model model = build_model(split_scene());
  SplitGrasp grasp(model);

  State state(model);
  Frame frame(model);
  Controller controller(model);
  ContactWorkspace work(model, split_policy(model.scene));
  control_tick(model, state, controller, frame);
  EXPECT_GE(grasp.first_control().total_s, 0.0);
  EXPECT_GT(grasp.first_control().f_desired.norm(), 0.0);

  for (int tick = 0; tick < 300; ++tick) {
    if (tick > 0 && model.control_is_due(tick)) {
      control_tick(model, state, controller, frame);
      const ControlStep step = grasp.control_step();
      EXPECT_TRUE(step.published);
      EXPECT_EQ(step.sequence, frame.sequence);
      EXPECT_EQ(step.snapshot_tick, tick);
    }
    const TickReport report = contact_tick(model, frame, work, state);
    const ContactStep step = grasp.contact_step();
    ASSERT_EQ(step.tick.sequence, report.sequence);
    ASSERT_EQ(step.tick.handed_over, report.handed_over);
    ASSERT_EQ(grasp.state().q, state.q) << tick;
    ASSERT_EQ(grasp.state().X_WO.matrix(), state.X_WO.matrix()) << tick;
  }
  EXPECT_GT(state.load[0].normal_N, 0.5);  // It does hold the box.
  EXPECT_EQ(grasp.frames().counts().published, 60);
  EXPECT_EQ(grasp.frames().counts().consumed, 60);
  EXPECT_EQ(grasp.snapshots().counts().published, 300);
}

TEST(SplitGrasp, ContactStepsTakeNoMemoryFromTheFirstOn) {
  if (!AllocationCounter::is_available()) GTEST_SKIP() << "malloc belongs to somebody else";
  const Model model = build_model(split_scene());
  State start(model);
  start.forces.shrink_to_fit();  // as a copy of a state has none to spare
  SplitGrasp grasp(model, start);
  std::int64_t allocations = 0;
  for (int tick = 0; tick < 200; ++tick) {
    if (tick % 5 == 4) grasp.control_step();
    const AllocationCounter counter;
    const ContactStep step = grasp.contact_step();
    allocations += counter.count();
    ASSERT_EQ(step.tick.handed_over, tick % 5 == 4 || tick == 0);
  }
  EXPECT_EQ(allocations, 0);
}

TEST(SplitGrasp, StaysFiniteWhateverTheInput) {
  const Model model = build_model(split_scene());
  SplitGrasp grasp(model);
  TickInput bad;
  bad.wrench[1] = std::numeric_limits<double>::quiet_NaN();
  bad.X_WT = Eigen::Isometry3d::Identity();
  bad.X_WT->translation().x() = std::numeric_limits<double>::infinity();
  for (int tick = 0; tick < 200; ++tick) {
    if (tick % 5 == 4) grasp.control_step();
    const ContactStep step = grasp.contact_step(tick == 50 ? bad : TickInput{});
    ASSERT_EQ(step.tick.input_refused, tick == 50);
    ASSERT_TRUE(is_finite(grasp.state())) << tick;
  }
}

/// Both loops on one thread, from the grasp's tick to another.
void run(SplitGrasp& grasp, std::int64_t end) {
  while (grasp.state().tick < end) {
    if (grasp.state().tick > 0 && grasp.model().control_is_due(grasp.state().tick)) grasp.control_step();
    grasp.contact_step();
  }
}

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

// Held back by the runner or on a channel's way, frames come into use at the same time: to the last bit.
TEST(SplitGrasp, HoldsFramesBackAsADelayDoes) {
  Scene scene = split_scene();
  scene.control_delay_s = 3.0 * scene.control_period_s;
  const Model model = build_model(scene);
  SplitGrasp grasp(model);
  grasp.hold_frames_back(3);
  GraspRun delayed(model, LockstepSettings{});
  for (int tick = 0; tick < 300; ++tick) {
    if (tick > 0 && model.control_is_due(tick)) grasp.control_step();
    const ContactStep step = grasp.contact_step();
    const TickReport report = delayed.tick();
    ASSERT_EQ(step.tick.sequence, report.sequence) << tick;
    ASSERT_FALSE(step.tick.held) << tick;
    ASSERT_EQ(grasp.state().q, delayed.state.q) << tick;
  }
  EXPECT_GT(grasp.state().load[0].normal_N, 0.5);
  EXPECT_EQ(grasp.frames().counts().unaccounted(), 0);
  // With less delay the newest on its way comes into use at once, and nothing is held.
  grasp.hold_frames_back(2);
  EXPECT_FALSE(grasp.contact_step().tick.held);
  // And without a delay the newest is there at once.
  grasp.hold_frames_back(0);
  const std::int64_t newest = grasp.control_step().sequence;
  EXPECT_EQ(grasp.contact_step().tick.sequence, newest);
}

TEST(SplitGrasp, LosesWhatLessFrictionCannotHold) {
  const auto most_slip_m = [](double friction) {
    Model model = build_model(split_scene());  // carried sideways from 0.4 to 1.2 s
    SplitGrasp grasp(model);
    run(grasp, 350);
    model.scene.contact.friction = friction;
    grasp.heed_scene();
    std::array<double, kFingers> slip_m{};
    while (grasp.state().tick < 1200) {
      if (model.control_is_due(grasp.state().tick)) grasp.control_step();
      const TickReport tick = grasp.contact_step().tick;
      for (int k = 0; k < kFingers; ++k) slip_m[k] += tick.patch[k].slip_m;
    }
    return *std::max_element(slip_m.begin(), slip_m.end());
  };
  EXPECT_LT(most_slip_m(0.8), 0.15e-3);
  EXPECT_GT(most_slip_m(0.2), 2e-3);  // lost, says the monitor
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

INSTANTIATE_TEST_SUITE_P(SplitGrasp, ChangedGrasp,
                         testing::Values(Change{"Nothing", PulpKernel::kBoussinesq, 0, 1e-3},
                                         Change{"Coarse", PulpKernel::kBoussinesq, 2, 1e-3},
                                         Change{"Gaussian", PulpKernel::kGaussian, 0, 1e-3},
                                         Change{"CoarseGaussian", PulpKernel::kGaussian, 3, 1e-3},
                                         Change{"FasterContact", PulpKernel::kBoussinesq, 0, 0.25e-3},
                                         Change{"SlowerContact", PulpKernel::kBoussinesq, 0, 5e-3}),
                         [](const auto& change) { return std::string(change.param.name); });

TEST(SplitGrasp, RefusesAFirstFrameThatIsNotFinite) {
  const Model model = build_model(scene_of("minimal"));
  State start(model);
  start.q[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(SplitGrasp(model, start), std::runtime_error);
}

}  // namespace
}  // namespace thenar::split_grasp_test
