// SPDX-License-Identifier: Apache-2.0
#include "engine/control/afference.h"

#include <gtest/gtest.h>

#include <string>

#include "engine/models/build_model.h"
#include "tests/support/scenes.h"

namespace thenar::afference_test {
namespace {

// The newest snapshot that is old enough, at any spacing of control ticks; before there is one, the oldest.
TEST(Afference, HasWhatWasKnownADelayAgo) {
  const Model model = build_model(scene_of("box_load", {kCoarseBox, "time.control_period=5 ms"}));
  Afference afference(model);
  ASSERT_TRUE(afference.is_needed());
  Snapshot snapshot = State(model);
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(9);
  const std::int64_t delay = ticks_of(model, model.scene.fingertips->touch->delay_s);
  EXPECT_EQ(delay, 65);
  for (int i = 0; i < 1000; ++i) {
    afference.add(snapshot, none);
    const std::int64_t seen = afference.at(snapshot.tick - delay).snapshot.tick;
    if (snapshot.tick < delay) {
      EXPECT_EQ(seen, 0);
    } else {
      EXPECT_LE(seen, snapshot.tick - delay);
      EXPECT_GT(seen, snapshot.tick - delay - 15);  // Control ticks are at most 15 ticks apart here.
    }
    snapshot.tick += i % 10 == 0 ? 15 : 5;  // Now and then two are missed.
  }
}

// A control loop that is ahead sees a snapshot more than once; one that is made faster while it runs sees more of them;
// a finer step has other ticks for the same times. What is known stays as old as it was.
TEST(Afference, StaysAsLateWhenLoopsChange) {
  const auto model_with = [](const std::string& step) {
    return build_model(scene_of("box_load", {kCoarseBox, "time.step=" + step, "time.control_period=5 ms"}));
  };
  const Model model = model_with("1 ms"), finer = model_with("0.5 ms");
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(9);
  Afference afference(model);
  Snapshot snapshot = State(model);
  for (; snapshot.tick < 500; snapshot.tick += 5) afference.add(snapshot, none);
  for (int i = 0; i < 80; ++i) afference.add(snapshot, none);
  EXPECT_EQ(afference.at(500 - 65).snapshot.tick, 435);
  for (; snapshot.tick < 700; ++snapshot.tick) afference.add(snapshot, none);
  EXPECT_EQ(afference.at(699 - 65).snapshot.tick, 634);
  const Afference after(finer, model, afference);
  EXPECT_EQ(after.at(2 * (699 - 65)).snapshot.tick, 2 * 634);
}

TEST(Afference, IsNotThereWithoutADelay) { EXPECT_FALSE(Afference(build_model(scene_of("minimal"))).is_needed()); }

}  // namespace
}  // namespace thenar::afference_test
