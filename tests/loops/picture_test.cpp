#include "engine/loops/picture.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/allocation_counter.h"
#include "tests/support/scenes.h"

namespace thenar::picture_test {
namespace {

TEST(RecordingFile, TakesAPictureWithoutMemory) {
  if (!AllocationCounter::is_available()) GTEST_SKIP() << "malloc belongs to somebody else";
  Loop loop(scene_of("box_grasp", {kCoarseBox}));
  Picture picture(loop.model);
  loop.run(0.2);
  const AllocationCounter counter;
  take_picture(loop.state, loop.work, picture);
  EXPECT_EQ(counter.count(), 0);
  EXPECT_FALSE(picture.contacts.empty());
}

// A contact that is not loaded has no way.
TEST(Picture, ShowsHowFarEachContactHasSlipped) {
  Loop loop(scene_of("box_grasp", {kCoarseBox, "contact.friction=0.1"}));  // Which does not hold the box.
  Picture picture(loop.model);
  loop.run(0.02);
  take_picture(loop.state, loop.work, picture);
  double most_m = 0.0;
  for (std::size_t i = 0; i < picture.contacts.size(); ++i) {
    const double slip_m = picture.contacts[i].slip_m;
    most_m = std::max(most_m, slip_m);
    const auto point = std::ranges::find(loop.work.patches.points, static_cast<Eigen::Index>(i), &PatchPoint::contact);
    EXPECT_EQ(slip_m, point == loop.work.patches.points.end() ? 0.0 : point->d_W.norm());
  }
  EXPECT_GT(most_m, 1e-6 * loop.model.scene.step_s);
}

}  // namespace
}  // namespace thenar::picture_test
