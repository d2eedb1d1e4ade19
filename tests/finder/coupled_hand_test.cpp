// SPDX-License-Identifier: Apache-2.0
// What the finder does with a hand in which joints follow others.

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "engine/finder/finder.h"
#include "engine/finder/fit.h"
#include "engine/finder/hand_body.h"
#include "engine/hand/coupled_joints.h"
#include "engine/hand/muscles.h"
#include "tests/finder/known_surfaces.h"

namespace thenar::coupled_hand_test {
namespace {

using namespace known_surfaces;
using Eigen::Index;
using Eigen::Vector3d;

/// hand.yaml whose fingers' last joints turn 0.7 times as far as those before them.
Hand coupled_hand() { return coupled(human_hand(), std::vector<Coupling>{{7, 6, 0.7, 0.0}, {11, 10, 0.7, 0.0}}); }

TEST(CoupledHand, FindsGrasps) {
  for (const ImplicitSurface& object : {box({0.05, 0.05, 0.05}), rod(0.015, 0.08)}) {
    const Hand whole = coupled_hand();  // which the problem refers to
    const FinderProblem problem = problem_of(whole, object);
    const FinderReport report = find_grasps(problem);
    ASSERT_EQ(report.grasps.size(), 1U) << (report.refusal ? report.refusal->reason : "");
    const FoundGrasp& grasp = report.grasps.front();
    const Hand hand = hand_of(problem.hand, grasp.fingers);
    ASSERT_EQ(grasp.q.size(), std::ssize(hand.joints));
    HandPose pose;
    forward_kinematics(hand, grasp.q, pose);
    for (int k = 0; k < hand.fingers(); ++k) {
      const PulpPose pulp = pulp_pose(hand, pose, k);
      const auto at = object.distance(grasp.X_WO.inverse() * pulp.centre_m, 1.0);
      ASSERT_TRUE(at);
      EXPECT_NEAR(at->distance_m, hand.fingertips[k].radius_m - grasp.places[k].depth_m, 1e-6);
    }
    for (Index i = 0; i < grasp.q.size(); ++i) {
      EXPECT_GE(grasp.q[i], hand.joints[i].lower_rad);
      EXPECT_LE(grasp.q[i], hand.joints[i].upper_rad);
    }
    for (const Follower& follower : hand.followers) {
      EXPECT_GE(follower.angle(grasp.q), follower.joint.lower_rad);
      EXPECT_LE(follower.angle(grasp.q), follower.joint.upper_rad);
    }
    EXPECT_GT(grasp.margin, 0.0);
  }
}

TEST(CoupledHand, KeepsItsCouplingsInASelectionOfFingers) {
  const Hand hand = coupled_hand(), part = hand_of(hand, {2, 0});
  ASSERT_EQ(part.followers.size(), 1U);
  EXPECT_EQ(part.followers[0].joint.name, "M_DIP_FE");
  EXPECT_EQ(part.joints[part.followers[0].leader].name, "M_PIP_FE");
  JointVector q = hand.at_zero(), q_part = part.at_zero();
  for (Index j = 0; j < q.size(); ++j) q[j] = 0.1 + 0.05 * static_cast<double>(j);
  q_part << q.head(4), q.tail(3);
  HandPose pose, pose_part;
  forward_kinematics(hand, q, pose);
  forward_kinematics(part, q_part, pose_part);
  EXPECT_EQ(pose.distal(hand, 2).matrix(), pose_part.distal(part, 1).matrix());
  Eigen::MatrixXd H(std::ssize(hand.joints), std::ssize(hand.muscles));
  Eigen::MatrixXd H_part(std::ssize(part.joints), std::ssize(part.muscles));
  moment_arms(hand, pose, H);
  moment_arms(part, pose_part, H_part);
  for (Index m = 0; m < H_part.cols(); ++m) {
    Index same = 0;
    while (hand.muscles[same].name != part.muscles[m].name) ++same;
    EXPECT_EQ(H_part(H_part.rows() - 1, m), H(H.rows() - 1, same)) << part.muscles[m].name;
  }
}

// In a posture that both hands have, a fit's residuals are the same, and its slopes are the full hand's, projected:
// q = S q_a. What a fit adds for limits and for the start is left out.
TEST(CoupledHand, FitsHaveTheProjectedSlopes) {
  const Hand hand = coupled_hand();
  const ImplicitSurface object = ball(0.024);
  const auto equations = [&](const Hand& of, const JointVector& q) {
    const std::vector<BodyPoint> body = hand_body(of);
    Stance stance{q};
    stance.X_WO.translation() = Vector3d(0.12, 0.035, 0.035);
    FitTarget target;
    target.depth_m = PerFinger<double>(of.fingers(), 1e-3);
    target.q_near = q;
    target.limits = false;
    return StanceFit(of, body, object).equations(stance, target);
  };
  JointVector q = hand.at_zero(), q_full = human_hand().at_zero();
  q << 0.1, 0.2, 0.0, 0.5, 0.3, 0.0, 0.6, 0.35, 0.0, 0.7;
  q_full << q.head(7), 0.7 * 0.6, q.tail(3), 0.7 * 0.7;
  const NormalEquations at = equations(hand, q), full = equations(human_hand(), q_full);
  Unknowns projected(at.Jr.size());
  projected << full.Jr.head(7), full.Jr.segment<3>(8), full.Jr.tail<6>();
  projected[6] += 0.7 * full.Jr[7];
  projected[9] += 0.7 * full.Jr[11];
  EXPECT_NEAR(at.cost, full.cost, 1e-9 * full.cost);
  EXPECT_LT((at.Jr - projected).norm(), 1e-9 * projected.norm());
  EXPECT_GT(std::abs(full.Jr[7]), 1e-6 * projected.norm()) << "or nothing is tested";
}

}  // namespace
}  // namespace thenar::coupled_hand_test
