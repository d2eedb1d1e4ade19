#include "engine/loops/picture.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace thenar::picture_test
