// SPDX-License-Identifier: Apache-2.0
// Which fingers of a hand can face each other.

#include "engine/capacity/opposition.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "engine/scenes/hand_file.h"

namespace thenar::opposition_test {
namespace {

using Eigen::Vector3d;

/// Two fingers of one joint each on the x axis, 100 mm apart, with bones of 50 mm along z at zero that turn towards one
/// another by up to `most_rad`, and pulps of 10 mm that look where they turn to; or, if they do not oppose, away from
/// it.
Hand pincers(double most_rad, bool oppose) {
  Hand hand;
  Segment palm;
  palm.X_WS_0.setIdentity();
  hand.segments.push_back(palm);
  for (int k = 0; k < 2; ++k) {
    const double side = k == 0 ? -1.0 : 1.0;
    hand.joints.push_back({"", {side * 0.05, 0, 0}, {0, -side, 0}, 0.0, most_rad});
    Segment bone;
    bone.finger = k;
    bone.joints = 1;
    bone.X_WS_0.setIdentity();
    bone.X_WS_0.translation() = hand.joints.back().origin_m;
    hand.segments.push_back(bone);
    Fingertip tip;
    tip.first_joint = k;
    tip.joints = 1;
    tip.segment = k + 1;
    tip.centre_m = Vector3d(0, 0, 0.05);
    tip.radius_m = 0.01;
    tip.normal = Vector3d(oppose ? -side : side, 0, 0);
    hand.fingertips.push_back(tip);
  }
  return hand;
}

TEST(Opposition, PincersFaceEachOtherWhereTheirPulpsLookAtOneAnother) {
  // Both turned by a, the pulps look down by a from the line between them: up to 30 degrees that will do. They are
  // 100 mm - 2 * 50 mm sin a apart, less two radii.
  const std::vector<FacingFingers> pairs = find_oppositions(pincers(0.5 * std::numbers::pi, true));
  ASSERT_EQ(pairs.size(), 1U);
  EXPECT_EQ(pairs[0].one, 0);
  EXPECT_EQ(pairs[0].other, 1);
  EXPECT_NEAR(pairs[0].most_m, 0.08, 1e-3) << "at zero";
  EXPECT_NEAR(pairs[0].least_m, 0.1 - 0.1 * std::sin(std::numbers::pi / 6) - 0.02, 3e-3) << "at 30 degrees";
}

TEST(Opposition, PincersWhosePulpsLookAwayDoNot) {
  EXPECT_TRUE(find_oppositions(pincers(0.5 * std::numbers::pi, false)).empty());
}

TEST(Opposition, TheThumbOfEveryHandThatComesWithTheProgramFacesAllFingers) {
  for (const char* name : {"three_finger", "human5", "leap", "allegro"}) {
    const Hand hand = load_hand(std::filesystem::path(THENAR_CONFIGS) / "hands" / (std::string(name) + ".yaml"));
    const std::vector<FacingFingers> pairs = find_oppositions(hand);
    for (int k = 1; k < hand.fingers(); ++k) {
      const bool faces = std::ranges::any_of(pairs, [&](const FacingFingers& p) { return p.one == 0 && p.other == k; });
      EXPECT_TRUE(faces) << name << " " << hand.fingertips[k].finger;
    }
  }
}

}  // namespace
}  // namespace thenar::opposition_test
