// What the finder does with a hand in which joints follow others.

#include <gtest/gtest.h>

#include <vector>

#include "engine/finder/finder.h"
#include "engine/finder/fit.h"
#include "engine/finder/hand_body.h"
#include "engine/grasp/coupled_joints.h"
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
    const FinderProblem problem = problem_of(coupled_hand(), object);
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

// The slopes of a fit's sum of squares, half of them J'r, against central differences.
TEST(CoupledHand, FitsHaveTheSlopesOfTheirCosts) {
  const Hand hand = coupled_hand();
  const std::vector<BodyPoint> body = hand_body(hand);
  const ImplicitSurface object = ball(0.024);
  StanceFit fit(hand, body, object);
  Stance stance{hand.at_zero()};
  stance.q << 0.1, 0.2, 0.0, 0.5, 0.3, 0.0, 0.6, 0.35, 0.0, 0.6;
  stance.X_WO.translation() = Vector3d(0.12, 0.035, 0.035);
  FitTarget target;
  target.depth_m = PerFinger<double>(hand.fingers(), 1e-3);
  target.q_near = stance.q;
  const NormalEquations at = fit.equations(stance, target);
  for (Index j = 0; j < stance.q.size(); ++j) {
    constexpr double kStep = 1e-6;
    Stance plus = stance, minus = stance;
    plus.q[j] += kStep;
    minus.q[j] -= kStep;
    const double slope = (fit.equations(plus, target).cost - fit.equations(minus, target).cost) / (4.0 * kStep);
    // The surface's slopes are themselves differences over 0.4 mm.
    EXPECT_NEAR(at.Jr[j], slope, 0.03 * at.Jr.cwiseAbs().maxCoeff()) << hand.joints[j].name;
  }
}

}  // namespace
}  // namespace thenar::coupled_hand_test
