// SPDX-License-Identifier: Apache-2.0
#include "engine/loops/run_state.h"

#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <vector>

#include "engine/models/build_model.h"
#include "tests/support/scenes.h"

namespace thenar::run_state_test {
namespace {

struct Case {
  std::string scene;
  std::vector<std::string> changes;
  std::int64_t before = 60, after = 60;  ///< Ticks.
};

const std::string kSoftBox = "object.compliance={reduced_modulus: 1 MPa, poisson: 0.5, relaxation: 5 ms}";

std::string name_of(const testing::TestParamInfo<Case>& info) { return info.param.scene + std::to_string(info.index); }

GraspRun run_of(const Model& model, bool is_lockstep) {
  return is_lockstep ? GraspRun(model, LockstepSettings{.jitter_s = 1e-3, .seed = 3}) : GraspRun(model);
}

/// That every number of two runs is the same, their memory, too; but for the time that a control tick took.
void expect_same(GraspRun& one, GraspRun& other) {
  for (GraspRun* run : {&one, &other}) {
    for (double ControlReport::*time : {&ControlReport::find_s, &ControlReport::factors_s, &ControlReport::grasp_s,
                                        &ControlReport::muscle_s, &ControlReport::total_s}) {
      run->report.*time = 0.0;
    }
  }
  EXPECT_TRUE(state_of(one) == state_of(other));
}

class RunState : public testing::TestWithParam<Case> {};

// A run that goes on from a state does bit for bit what a plain copy does, and what the run itself does; in one loop
// and in lockstep with frames under way.
TEST_P(RunState, GoesOnAsACopyWould) {
  const Model model = build_model(scene_of(GetParam().scene, GetParam().changes));
  for (const bool is_lockstep : {false, true}) {
    GraspRun run = run_of(model, is_lockstep), copy = run_of(model, is_lockstep), read = run_of(model, is_lockstep);
    for (std::int64_t i = 0; i < GetParam().before; ++i) (void)run.tick();
    copy.go_on_as(run);
    for (int i = 0; i < 5; ++i) (void)read.tick();  // What it did before is forgotten.
    set_state(state_of(run), read);
    expect_same(run, read);
    for (std::int64_t i = 0; i < GetParam().after; ++i) {
      for (GraspRun* one : {&run, &copy, &read}) (void)one->tick();
      ASSERT_EQ(run.state.q, read.state.q) << i;
      ASSERT_EQ(copy.state.q, read.state.q) << i;
      ASSERT_EQ(run.state.X_WO.matrix(), read.state.X_WO.matrix()) << i;
    }
    expect_same(run, read);
    expect_same(run, copy);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Scenes, RunState,
    testing::Values(Case{"minimal", {}}, Case{"box_grasp", {kCoarseBox}},
                    Case{"box_grasp", {kCoarseBox, "time.control_period=5 ms", "time.control_delay=4 ms"}},
                    Case{"box_grasp", {kCoarseBox, kSoftBox}}, Case{"box_stiff", {kCoarseBox}, 120, 40},
                    Case{"box_wet", {kCoarseBox}}, Case{"resting_box", {}}, Case{"slides_ball", {}},
                    Case{"unknown_friction", {}}, Case{"pick_and_place", {}, 400, 100}),
    name_of);

class RefusedState : public testing::Test {
 protected:
  RefusedState() {
    for (int i = 0; i < 30; ++i) (void)run.tick();
    bytes = state_of(run);
  }
  /// Neither crashes nor changes the run.
  void expect_refused(const std::string& bad) {
    EXPECT_THROW(set_state(bad, run), std::invalid_argument);
    EXPECT_TRUE(state_of(run) == bytes);
  }

  Model model = build_model(scene_of("box_grasp", {kCoarseBox}));
  GraspRun run{model};
  std::string bytes;
};

TEST_F(RefusedState, WhatIsNotWhole) {
  for (std::size_t i = 0; i < 50; ++i) expect_refused(bytes.substr(0, i * bytes.size() / 50));
  expect_refused(bytes.substr(0, bytes.size() - 1));
  expect_refused(bytes + '\0');
}

TEST_F(RefusedState, WhatIsDamagedOrForeign) {
  for (std::size_t i = 0; i < 50; ++i) {
    std::string bad = bytes;
    bad[i * bad.size() / 50] ^= 0x20;
    expect_refused(bad);
  }
  expect_refused(std::string(bytes.size(), '\xff'));
}

TEST_F(RefusedState, ThatOfAnotherSceneOrKindOfRun) {
  const Model stiffer = build_model(scene_of("box_grasp", {kCoarseBox, "time.step=0.5 ms"}));
  for (const Model& other : {build_model(scene_of("minimal")), stiffer}) expect_refused(state_of(GraspRun(other)));
  expect_refused(state_of(GraspRun(model, LockstepSettings{})));
}

// Sizes of sealed members that cannot be end with the bytes: they take no memory.
TEST_F(RefusedState, SizesThatCannotBe) {
  const std::uint64_t fingerprint = state_fingerprint(model, false);
  const std::string good(opened_state(fingerprint, bytes));
  for (std::size_t i = 0; i + 8 <= good.size() && i < 4000; i += 8) {
    std::string bad = good;
    bad.replace(i, 8, 8, '\xff');
    GraspRun other(model);
    try {
      set_state(sealed_state(fingerprint, bad), other);
    } catch (const std::invalid_argument&) {
    }
  }
}

}  // namespace
}  // namespace thenar::run_state_test
