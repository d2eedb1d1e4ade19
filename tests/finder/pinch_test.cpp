// SPDX-License-Identifier: Apache-2.0
#include "engine/finder/pinch.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/finder/known_surfaces.h"

namespace thenar::pinch_test {
namespace {

using namespace known_surfaces;
using Eigen::Vector3d;

// The thumb is the finger that opposes, and in each posture pulps face across a gap of the width, within their limits.
TEST(Pinches, FaceAcrossTheirWidth) {
  const Hand& hand = human_hand();
  const PinchRange range = find_pinches(hand, 1, 1);
  ASSERT_EQ(range.opposer, 0);
  EXPECT_LT(range.least_m, 0.01);
  EXPECT_GT(range.most_m, 0.05);
  for (const Pinch& pinch : range.postures) {
    HandPose pose;
    forward_kinematics(hand, pinch.q, pose);
    const PulpPose thumb = pulp_pose(hand, pose, 0), index = pulp_pose(hand, pose, 1), major = pulp_pose(hand, pose, 2);
    const Vector3d v = 0.5 * (index.centre_m + major.centre_m) - thumb.centre_m;
    const double radii_m = hand.fingertips[0].radius_m + hand.fingertips[1].radius_m;
    EXPECT_NEAR(v.norm() - radii_m, pinch.width_m, 1e-3);  // what find_pinches lets pass
    EXPECT_GT(thumb.normal.dot(v.normalized()), std::cos(kFacing_rad));
    EXPECT_LT(index.normal.dot(v.normalized()), -std::cos(kFacing_rad));
    EXPECT_LT(major.normal.dot(v.normalized()), -std::cos(kFacing_rad));
    for (Eigen::Index i = 0; i < pinch.q.size(); ++i) {
      EXPECT_GE(pinch.q[i], hand.joints[i].lower_rad);
      EXPECT_LE(pinch.q[i], hand.joints[i].upper_rad);
    }
  }
}

// The fingers' order in the hand is no anatomy.
TEST(Pinches, FindTheOpposerWhereverItStands) {
  const Hand& hand = human_hand();
  Hand turned = hand;
  turned.joints.clear();
  turned.fingertips.clear();
  turned.muscles.clear();
  for (const int k : {1, 2, 0}) {
    Fingertip tip = hand.fingertips[k];
    const int first = tip.first_joint;
    tip.first_joint = static_cast<int>(turned.joints.size());
    for (int j = 0; j < tip.joints; ++j) turned.joints.push_back(hand.joints[first + j]);
    turned.fingertips.push_back(tip);
  }
  for (Segment& segment : turned.segments) {
    if (segment.joints > 0) segment.finger = (segment.finger + 2) % 3;
  }
  EXPECT_EQ(find_pinches(turned, 1, 1).opposer, 2);
}

// A thumb that lies stretched beside the hand faces nothing.
TEST(Pinches, AreNoneOfAThumbThatCannotOppose) {
  Hand hand = human_hand();
  for (Joint& joint : hand.joints) {
    joint.lower_rad = -0.02;
    joint.upper_rad = 0.02;
  }
  const PinchRange range = find_pinches(hand, 1, 1);
  EXPECT_EQ(range.opposer, -1);
  EXPECT_GT(range.best_facing_rad, kFacing_rad);
}

}  // namespace
}  // namespace thenar::pinch_test
