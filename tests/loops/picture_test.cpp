// SPDX-License-Identifier: Apache-2.0
#include "engine/loops/picture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

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
  take_picture(loop.state, loop.memory, loop.work, picture);
  EXPECT_EQ(counter.count(), 0);
  EXPECT_FALSE(picture.contacts.empty());
}

// A contact that is not loaded has no way.
TEST(Picture, ShowsHowFastEachContactSlips) {
  Loop loop(scene_of("box_grasp", {kCoarseBox, "contact.friction=0.1"}));  // Which does not hold the box.
  Picture picture(loop.model);
  loop.run(0.02);
  take_picture(loop.state, loop.memory, loop.work, picture);
  double fastest_m_per_s = 0.0;
  for (std::size_t i = 0; i < picture.contacts.size(); ++i) {
    const double speed_m_per_s = picture.contacts[i].slip_m_per_s;
    fastest_m_per_s = std::max(fastest_m_per_s, speed_m_per_s);
    const auto point = std::ranges::find(loop.work.patches.points, static_cast<Eigen::Index>(i), &PatchPoint::contact);
    EXPECT_EQ(speed_m_per_s,
              point == loop.work.patches.points.end() ? 0.0 : point->d_W.norm() / loop.model.scene.step_s);
  }
  EXPECT_GT(fastest_m_per_s, 1e-6);
}

// At an edge contacts stand for parts of their cells, and lean: what their cones bound are no parts along the normal
// and across it.
TEST(Picture, ShowsContactsAtEdgesAsWhatTheyAre) {
  Loop loop(scene_of("box_edge"));
  Picture picture(loop.model);
  loop.run(0.1);
  take_picture(loop.state, loop.memory, loop.work, picture);
  int parts = 0, leaning = 0;
  for (const ShownContact& contact : picture.contacts) {
    EXPECT_GT(contact.share, 0.0);
    EXPECT_LE(contact.share, 1.0);
    EXPECT_LE(contact.friction_N, (1.0 + 1e-5) * 0.8 * contact.normal_N + 1e-9);
    const double along_N = contact.force_N.dot(contact.normal);
    if (contact.share < 1.0 && contact.normal_N > 0.0) {
      ++parts;
      leaning += std::abs(along_N - contact.normal_N) > 1e-3 * contact.normal_N ? 1 : 0;
    } else {
      EXPECT_NEAR(along_N, contact.normal_N, 1e-12);
    }
  }
  EXPECT_GT(parts, 5);
  EXPECT_GT(leaning, 0);
}

}  // namespace
}  // namespace thenar::picture_test
