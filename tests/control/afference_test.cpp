#include "engine/control/afference.h"

#include <gtest/gtest.h>

#include "engine/scenes/build_model.h"
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

TEST(Afference, IsNotThereWithoutADelay) { EXPECT_FALSE(Afference(build_model(scene_of("minimal"))).is_needed()); }

}  // namespace
}  // namespace thenar::afference_test
