// SPDX-License-Identifier: Apache-2.0
#include "engine/finder/hand_body.h"

#include <gtest/gtest.h>

#include <Eigen/SVD>
#include <algorithm>

#include "engine/finder/pressed_shape.h"
#include "engine/hand/muscles.h"
#include "tests/finder/known_surfaces.h"

namespace thenar::hand_body_test {
namespace {

using namespace known_surfaces;

JointVector some_posture(const Hand& hand) {
  JointVector q = hand.at_zero();
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const Joint& joint = hand.joints[i];
    q[i] = joint.lower_rad + (0.3 + 0.03 * static_cast<double>(i)) * (joint.upper_rad - joint.lower_rad);
  }
  return q;
}

// A hand without its index moves the thumb and the major as the whole hand does.
TEST(HandOf, MovesTheFingersThatAreLeftAsBefore) {
  const Hand& whole = human_hand();
  const Hand part = hand_of(whole, {2, 0});
  ASSERT_EQ(part.fingers(), 2);
  EXPECT_EQ(part.fingertips[0].finger, "thumb");
  EXPECT_EQ(part.fingertips[1].finger, "major");
  const JointVector q = some_posture(whole);
  JointVector q_part = part.at_zero();
  q_part << q.head(4), q.tail(4);
  HandPose pose, pose_part;
  forward_kinematics(whole, q, pose);
  forward_kinematics(part, q_part, pose_part);
  for (int k = 0; k < 2; ++k) {
    EXPECT_EQ(pulp_pose(part, pose_part, k).centre_m, pulp_pose(whole, pose, 2 * k).centre_m);
    EXPECT_EQ(pulp_pose(part, pose_part, k).J_normal, pulp_pose(whole, pose, 2 * k).J_normal);
  }
  // Muscles do to the joints that are left what they did.
  Eigen::MatrixXd H(12, static_cast<Eigen::Index>(whole.muscles.size()));
  Eigen::MatrixXd H_part(8, static_cast<Eigen::Index>(part.muscles.size()));
  moment_arms(whole, pose, H);
  moment_arms(part, pose_part, H_part);
  EXPECT_LT(part.muscles.size(), whole.muscles.size());
  for (std::size_t m = 0; m < part.muscles.size(); ++m) {
    const auto same = [&](const Muscle& muscle) { return muscle.name == part.muscles[m].name; };
    const auto found = std::find_if(whole.muscles.begin(), whole.muscles.end(), same);
    ASSERT_NE(found, whole.muscles.end());
    const auto column = found - whole.muscles.begin();
    EXPECT_EQ(H_part.col(static_cast<Eigen::Index>(m)).head(4), H.col(column).head(4)) << part.muscles[m].name;
    EXPECT_EQ(H_part.col(static_cast<Eigen::Index>(m)).tail(4), H.col(column).tail(4)) << part.muscles[m].name;
  }
}

// What a pulp's normal does when a joint turns, by differences of the whole kinematics.
TEST(PulpPose, KnowsHowItMoves) {
  const Hand& hand = human_hand();
  const JointVector q = some_posture(hand);
  HandPose pose, moved;
  forward_kinematics(hand, q, pose);
  constexpr double kStep = 1e-6;  // Forward differences then err by about as much.
  for (int k = 0; k < hand.fingers(); ++k) {
    const PulpPose pulp = pulp_pose(hand, pose, k);
    for (int j = 0; j < hand.fingertips[k].joints; ++j) {
      JointVector near = q;
      near[hand.fingertips[k].first_joint + j] += kStep;
      forward_kinematics(hand, near, moved);
      const PulpPose then = pulp_pose(hand, moved, k);
      EXPECT_LT(((then.centre_m - pulp.centre_m) / kStep - pulp.J_centre.col(j)).norm(), 10.0 * kStep);
      EXPECT_LT(((then.normal - pulp.normal) / kStep - pulp.J_normal.col(j)).norm(), 10.0 * kStep);
    }
  }
}

// A finger whose joints all turn about parallel axes moves its pulp in a plane: across it no torque pushes.
TEST(Dexterity, IsNothingWhereNoTorquePushes) {
  Hand hand = human_hand();
  for (int j = 4; j < 8; ++j) hand.joints[j].axis = hand.joints[5].axis;
  HandPose pose;
  forward_kinematics(hand, some_posture(hand), pose);
  const Eigen::Vector3d centre_m = pose.distal(hand, 1) * hand.fingertips[1].centre_m;
  EXPECT_LT(dexterity(hand, pose, 1, centre_m), 1e-6);
  // Against singular values of the same Jacobian, from its own definition.
  const Eigen::Vector3d thumb_m = pose.distal(hand, 0) * hand.fingertips[0].centre_m;
  const Eigen::MatrixXd J = finger_jacobian(hand, pose, 0, thumb_m);
  const Eigen::VectorXd values = J.jacobiSvd().singularValues();
  EXPECT_NEAR(dexterity(hand, pose, 0, thumb_m), values[2] / values[0], 1e-9);
}

// On a plane a pressed pulp touches below its middle, across the plane; on a ball, too.
TEST(PressedContact, IsWhatSymmetrySays) {
  const ImplicitSurface cube = box({0.04, 0.04, 0.04}), sphere = ball(0.02);
  const Eigen::Isometry3d X_WO(Eigen::AngleAxisd(0.5, Eigen::Vector3d(1.0, 2.0, 3.0).normalized()));
  const GraspContact flat = pressed_contact(cube, X_WO, X_WO * Eigen::Vector3d(1e-3, 2e-3, 0.027), 0.008);
  EXPECT_LT((X_WO.inverse() * flat.point_m - Eigen::Vector3d(1e-3, 2e-3, 0.02)).norm(), 2e-5);
  EXPECT_LT((X_WO.linear().transpose() * flat.axes.col(0) + Eigen::Vector3d::UnitZ()).norm(), 1e-6);
  const Eigen::Vector3d way = Eigen::Vector3d(2.0, -1.0, 1.0).normalized();
  const GraspContact round = pressed_contact(sphere, X_WO, X_WO * (0.027 * way), 0.008);
  EXPECT_LT((X_WO.linear().transpose() * round.axes.col(0) + way).norm(), 0.02) << "ten samples a patch";
}

TEST(HandBody, FollowsTheBonesFromThePalmToThePulps) {
  const std::vector<BodyPoint> body = hand_body(human_hand());
  for (const BodyPoint& point : body) EXPECT_GT(point.clearance_m, 0.0);
  for (std::size_t s = 1; s < human_hand().segments.size(); ++s) {
    const auto on = [&](const BodyPoint& point) { return point.segment == static_cast<int>(s); };
    EXPECT_GE(std::count_if(body.begin(), body.end(), on), 2) << human_hand().segments[s].name;
  }
}

// The open hand has no bones in one another, whatever its shape; a finger in another one's place has, by as much as
// both are thick but for what their joints are off one another.
TEST(Bones, KeepFingersApart) {
  const Hand& hand = human_hand();
  const Bones bones = bones_of(hand, hand_body(hand));
  JointVector q = hand.at_zero();
  for (Eigen::Index i = 0; i < q.size(); ++i)
    q[i] = std::clamp(0.0, hand.joints[i].lower_rad, hand.joints[i].upper_rad);
  HandPose pose;
  forward_kinematics(hand, q, pose);
  EXPECT_EQ(overlap_of(bones, pose).depth_m, 0.0);
  // The whole index where the major is.
  for (std::size_t s = 0; s < hand.segments.size(); ++s) {
    if (hand.segments[s].finger != 1 || hand.segments[s].joints == 0) continue;
    for (std::size_t other = 0; other < hand.segments.size(); ++other) {
      if (hand.segments[other].finger == 2 && hand.segments[other].joints == hand.segments[s].joints) {
        pose.segments[s] = pose.segments[other];
      }
    }
  }
  const BoneOverlap overlap = overlap_of(bones, pose);
  EXPECT_GT(overlap.depth_m, 0.5 * hand.fingertips[1].radius_m);
  EXPECT_EQ(std::min(overlap.finger, overlap.other), 1);
  EXPECT_EQ(std::max(overlap.finger, overlap.other), 2);
}

}  // namespace
}  // namespace thenar::hand_body_test
