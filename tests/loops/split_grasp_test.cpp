// SPDX-License-Identifier: Apache-2.0
#include "engine/loops/split_grasp.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <stdexcept>

#include "engine/loops/run.h"
#include "engine/models/build_model.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/scenes.h"
#include "tests/support/split_runs.h"
#include "tests/support/three_fingers.h"

namespace thenar::split_grasp_test {
namespace {

using namespace split_runs;

// The exchange adds nothing to the two ticks: the same calls in the same order, on a frame and a snapshot handed over
// by hand, give the same bits; so a draft's old contents do not leak into a frame either.
TEST(SplitGrasp, IsTheTwoTicksAndAnExchange) {
  const Model model = build_model(split_scene());
  SplitGrasp grasp(model);

  State state(model);
  Frame frame(model);
  Controller controller(model);
  ContactMemory memory(model, split_policy(model.scene));
  ContactScratch work(model);
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
    const TickReport report = contact_tick(model, frame, memory, work, state);
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

void expect_no_memory_taken(const Model& model) {
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

TEST(SplitGrasp, ContactStepsTakeNoMemoryFromTheFirstOn) {
  if (!AllocationCounter::is_available()) GTEST_SKIP() << "malloc belongs to somebody else";
  expect_no_memory_taken(build_model(split_scene()));
  // Muscles that take time, with a stiffness that is chosen.
  expect_no_memory_taken(build_model(scene_of("box_stiff", {kCoarseBox, "time.control_period=5 ms"})));
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

TEST(SplitGrasp, RefusesAFirstFrameThatIsNotFinite) {
  const Model model = build_model(scene_of("minimal"));
  State start(model);
  start.q[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(SplitGrasp(model, start), std::runtime_error);
}

}  // namespace
}  // namespace thenar::split_grasp_test
