// SPDX-License-Identifier: Apache-2.0
#include "engine/finder/finder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "engine/finder/hand_body.h"
#include "engine/finder/pinch.h"
#include "engine/finder/rate.h"
#include "solvers/grasp_forces.h"
#include "tests/finder/known_surfaces.h"

namespace thenar::finder_test {
namespace {

using namespace known_surfaces;
using Eigen::Vector3d;

/// All that a found grasp promises, checked from the hand's kinematics, the surface and the forces alone.
void expect_grasp(const FinderProblem& problem, const FoundGrasp& grasp) {
  const Hand hand = hand_of(problem.hand, grasp.fingers);
  HandPose pose;
  forward_kinematics(hand, grasp.q, pose);
  Vector3d force = problem.mass_kg * problem.gravity, moment = Vector3d::Zero();
  const Vector3d centre_m = grasp.X_WO * problem.centre_of_mass_m;
  for (int k = 0; k < hand.fingers(); ++k) {
    const FingerPlace& place = grasp.places[k];
    const PulpPose pulp = pulp_pose(hand, pose, k);
    const auto at = problem.object.distance(grasp.X_WO.inverse() * pulp.centre_m, 1.0);
    ASSERT_TRUE(at);
    EXPECT_NEAR(at->distance_m, hand.fingertips[k].radius_m - place.depth_m, 1e-6) << "pressed in as deep as it says";
    EXPECT_LE(place.depth_m, kTrustPerRadius * hand.fingertips[k].radius_m);
    EXPECT_LE(place.facing_rad, kFacing_rad);
    const Vector3d n = grasp.X_WO.linear() * -place.normal_O;
    const double normal_N = n.dot(place.force_W);
    EXPECT_GT(normal_N, 0.0);
    EXPECT_LE((place.force_W - normal_N * n).norm(), grasp.needed_friction * normal_N + 1e-9);
    force += place.force_W;
    moment += (grasp.X_WO * place.point_O - centre_m).cross(place.force_W);
  }
  EXPECT_LT(force.norm(), 1e-9);
  EXPECT_LT(moment.norm(), 1e-9);
  EXPECT_GT(grasp.margin, 0.0);
  EXPECT_LE(grasp.margin, 1.0 - grasp.needed_friction / problem.friction + 0.5);
  for (Eigen::Index i = 0; i < grasp.q.size(); ++i) {
    EXPECT_GE(grasp.q[i], hand.joints[i].lower_rad);
    EXPECT_LE(grasp.q[i], hand.joints[i].upper_rad);
  }
}

TEST(Finder, GraspsBallsBoxesAndRods) {
  const std::vector<ImplicitSurface> objects{
      ball(0.012), ball(0.024), box({0.05, 0.05, 0.05}), box({0.02, 0.07, 0.05}), rod(0.01, 0.08), rod(0.025, 0.06)};
  for (const ImplicitSurface& object : objects) {
    const FinderProblem problem = problem_of(human_hand(), object);
    const FinderReport report = find_grasps(problem);
    SCOPED_TRACE(object.bounds().sizes().transpose());
    ASSERT_EQ(report.grasps.size(), 1U) << (report.refusal ? report.refusal->reason : "");
    expect_grasp(problem, report.grasps.front());
  }
}

TEST(Finder, FindsTheSameBitsAgain) {
  const ImplicitSurface object = box({0.03, 0.04, 0.06});
  const FinderProblem problem = problem_of(human_hand(), object);
  const FinderReport one = find_grasps(problem, {.best = 3}), two = find_grasps(problem, {.best = 3});
  ASSERT_EQ(one.grasps.size(), two.grasps.size());
  for (std::size_t i = 0; i < one.grasps.size(); ++i) {
    EXPECT_EQ(one.grasps[i].q, two.grasps[i].q);
    EXPECT_EQ(one.grasps[i].X_WO.matrix(), two.grasps[i].X_WO.matrix());
    if (i == 0) continue;
    EXPECT_GE(one.grasps[i].cost, one.grasps[i - 1].cost) << "by rank";
  }
}

// The object's axes are the file's business: turned and moved in its frame it is held as well, if not at the same
// place.
TEST(Finder, GraspsInAnyFrame) {
  PointCloud cloud = sample_cylinder(0.015, 0.07, 6000);
  const Eigen::Matrix3d R = Eigen::AngleAxisd(1.1, Vector3d(1.0, -1.0, 0.5).normalized()).toRotationMatrix();
  const Vector3d t(0.05, -0.03, 0.02);
  cloud.points_m = (R * cloud.points_m).colwise() + t;
  cloud.normals = R * cloud.normals;
  const ImplicitSurface object(cloud);
  FinderProblem problem = problem_of(human_hand(), object);
  problem.centre_of_mass_m = t;
  const FinderReport report = find_grasps(problem);
  ASSERT_EQ(report.grasps.size(), 1U);
  expect_grasp(problem, report.grasps.front());
}

TEST(Finder, KeepsToWishes) {
  const ImplicitSurface object = box({0.03, 0.04, 0.07});
  FinderProblem problem = problem_of(human_hand(), object);
  problem.wish.axis_O = Vector3d::UnitY();
  problem.wish.at_O = Vector3d(0.0, 0.0, 0.015);
  problem.wish.press_N = 0.7;
  const FinderReport report = find_grasps(problem);
  ASSERT_EQ(report.grasps.size(), 1U) << (report.refusal ? report.refusal->reason : "");
  const FoundGrasp& grasp = report.grasps.front();
  expect_grasp(problem, grasp);
  for (const FingerPlace& place : grasp.places) EXPECT_NEAR(std::abs(place.normal_O.y()), 1.0, 1e-6);
  EXPECT_NEAR(grasp.width_m, 0.04, 2e-3);
  // At rest no finger presses with less, and one with no more.
  double least_N = 1e9;
  for (const FingerPlace& place : grasp.places) {
    least_N = std::min(least_N, -(grasp.X_WO.linear() * place.normal_O).dot(place.force_W));
  }
  EXPECT_NEAR(least_N, 0.7, 0.01 * 0.7) << "where the search for the internal force ends";
}

/// Why there is no grasp; nothing if there is one.
std::string reason_of(const FinderProblem& problem) {
  const FinderReport report = find_grasps(problem, {.second_look = false});
  return report.refusal ? report.refusal->reason : "";
}

// One muscle moves none of the fingers that it does not cross: the grasp fits, and torques would hold it.
TEST(Finder, TellsWhatMusclesDoNotGive) {
  const ImplicitSurface object = box({0.03, 0.04, 0.06});
  Hand hand = human_hand();
  hand.muscles.resize(1);
  FinderProblem problem = problem_of(hand, object);
  problem.muscles = true;
  const FinderReport report = find_grasps(problem, {.second_look = false});
  ASSERT_TRUE(report.refusal);
  EXPECT_TRUE(report.refusal->by_muscles) << report.refusal->reason;
  EXPECT_NE(report.refusal->reason.find("no muscle forces give the torques"), std::string::npos);
  // Joints of more than one finger lack one, and none that is named is crossed by the muscle that there is.
  const std::string& reason = report.refusal->reason;
  EXPECT_NE(reason.find("no muscle turns "), std::string::npos) << reason;
  EXPECT_NE(reason.find(", nor "), std::string::npos) << reason;
  for (const MuscleCrossing& crossing : hand.muscles.front().crossings) {
    for (const int joint : crossing.joints) {
      EXPECT_EQ(reason.find(hand.joints[joint].name + " towards"), std::string::npos) << reason;
    }
  }
  problem.muscles = false;
  EXPECT_FALSE(find_grasps(problem, {.second_look = false}).grasps.empty());
}

// Of three fingers the opposer bears what two others press, of five what four do.
TEST(Finder, PressesAsWishedWithAnyNumberOfFingers) {
  const Hand human5 = scene_of("human5_carry").hand;
  for (const Hand& hand : {hand_of(human5, {0, 1, 2}), human5}) {
    const ImplicitSurface object = box({0.035, 0.05, 0.09});
    FinderProblem problem = problem_of(hand, object);
    problem.wish.press_N = 0.6;
    const FinderReport report = find_grasps(problem);
    ASSERT_EQ(report.grasps.size(), 1U) << report.refusal->reason;
    const FoundGrasp& grasp = report.grasps.front();
    double least_N = 1e9;
    for (const FingerPlace& place : grasp.places) {
      least_N = std::min(least_N, -(grasp.X_WO.linear() * place.normal_O).dot(place.force_W));
    }
    EXPECT_NEAR(least_N, 0.6, 0.01 * 0.6) << hand.fingers();
  }
}

// A pulp as stiff as rubber bears loads under which the scene's would be pressed in too far.
TEST(Finder, KnowsThePulpsOwnMaterial) {
  const ImplicitSurface object = box({0.03, 0.04, 0.07});
  Hand hand = human_hand();
  const auto is_too_soft = [&] {
    FinderProblem problem = problem_of(hand, object);
    problem.material = PulpMaterial{.reduced_modulus_Pa = 0.24e6};
    problem.wish.press_N = 20.0;
    return reason_of(problem).find("is pressed in by half") != std::string::npos;
  };
  EXPECT_TRUE(is_too_soft());
  for (Fingertip& tip : hand.fingertips) tip.reduced_modulus_Pa = 10e6;
  EXPECT_FALSE(is_too_soft());
}

// Grasps that are ranked differ in what a user calls different, and a rank does not depend on how many are asked for.
TEST(Finder, RanksWhatIsUnlike) {
  const ImplicitSurface object = box({0.03, 0.04, 0.06});
  const FinderProblem problem = problem_of(human_hand(), object);
  const FinderReport few = find_grasps(problem, {.best = 3}), many = find_grasps(problem, {.best = 8});
  ASSERT_EQ(few.grasps.size(), 3U);
  EXPECT_GE(many.grasps.size(), 5U) << "three pairs of faces, and several ways to come to each";
  for (std::size_t i = 0; i < many.grasps.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) EXPECT_FALSE(alike(many.grasps[i], many.grasps[j])) << i << ", " << j;
    if (i >= few.grasps.size()) continue;
    EXPECT_EQ(few.grasps[i].q, many.grasps[i].q) << i;
  }
}

// Five fingers, of which none passes through another but for what flesh gives way.
TEST(Finder, KeepsBonesApart) {
  constexpr double kMostApart_m = 0.6e-3;  // Of FitFaults.
  const Hand whole = scene_of("human5_carry").hand;
  for (const ImplicitSurface& object : {ball(0.03), box({0.05, 0.06, 0.09})}) {
    const FinderReport report = find_grasps(problem_of(whole, object));
    ASSERT_EQ(report.grasps.size(), 1U) << report.refusal->reason;
    const FoundGrasp& grasp = report.grasps.front();
    const Hand hand = hand_of(whole, grasp.fingers);
    HandPose pose;
    forward_kinematics(hand, grasp.q, pose);
    EXPECT_LE(overlap_of(bones_of(hand, hand_body(hand)), pose).depth_m, kMostApart_m + 1e-12);
  }
}

TEST(Finder, SaysWhyThereIsNoGrasp) {
  const ImplicitSurface great = ball(0.12);
  EXPECT_NE(reason_of(problem_of(human_hand(), great)).find("and this hand opens"), std::string::npos);

  const ImplicitSurface small = box({0.03, 0.04, 0.05});
  const Hand lone = hand_of(human_hand(), {1});
  EXPECT_NE(reason_of(problem_of(lone, small)).find("one finger"), std::string::npos);
  const Hand pincers = hand_of(human_hand(), {0, 1});
  EXPECT_NE(reason_of(problem_of(pincers, small)).find("two fingers leave the turn"), std::string::npos);

  Hand stiff = human_hand();
  for (Joint& joint : stiff.joints) {
    joint.lower_rad = -0.02;
    joint.upper_rad = 0.02;
  }
  EXPECT_NE(reason_of(problem_of(stiff, small)).find("no finger can face"), std::string::npos);

  FinderProblem slippery = problem_of(human_hand(), small);
  slippery.friction = slippery.cone_friction = 0.001;
  EXPECT_FALSE(reason_of(slippery).empty());

  slippery.friction = slippery.cone_friction = 0.0;
  EXPECT_NE(reason_of(slippery).find("without friction"), std::string::npos);

  FinderProblem crushed = problem_of(human_hand(), small);
  crushed.wish.press_N = 100.0;
  EXPECT_NE(reason_of(crushed).find("a press of 100.0 N"), std::string::npos) << reason_of(crushed);

  FinderProblem beyond = problem_of(human_hand(), small);
  beyond.wish.at_O = Vector3d(0.0, 0.0, 0.1);
  EXPECT_NE(reason_of(beyond).find("away from the object"), std::string::npos) << reason_of(beyond);

  const ImplicitSurface crumb = ball(0.001);
  EXPECT_FALSE(reason_of(problem_of(human_hand(), crumb)).empty());
}

TEST(Finder, EndsWhereItIsTold) {
  const ImplicitSurface object = box({0.03, 0.04, 0.05});
  const FinderProblem problem = problem_of(human_hand(), object);
  int calls = 0;
  const FinderReport report = find_grasps(problem, {}, [&](double share, int) {
    EXPECT_GE(share, 0.0);
    EXPECT_LE(share, 1.0);
    return ++calls < 5;
  });
  EXPECT_TRUE(report.cancelled);
  EXPECT_FALSE(report.refusal) << "nobody knows";
  EXPECT_EQ(calls, 5);
  EXPECT_LT(report.fits, find_grasps(problem).fits);
}

}  // namespace
}  // namespace thenar::finder_test
