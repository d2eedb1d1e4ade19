// SPDX-License-Identifier: Apache-2.0
#include "engine/finder/carry.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/finder/known_surfaces.h"

namespace thenar::carry_test {
namespace {

using namespace known_surfaces;

FoundGrasp grasp_of(const FinderProblem& problem) {
  const FinderReport report = find_grasps(problem);
  EXPECT_EQ(report.grasps.size(), 1U);
  return report.grasps.front();
}

/// The travel of a grasp, anew.
FoundGrasp travel_of(const FinderProblem& problem, FoundGrasp grasp) {
  add_travel(problem, problem.hand, PatchMeter(problem.object, 4e-3), grasp);
  return grasp;
}

// A box of half the width that the hand opens to is carried by 20 mm and more; what it needs on the way is not less
// than what a sticking grasp may need.
TEST(Carry, GoesFarWithABoxThatSuitsTheHand) {
  const ImplicitSurface object = box({0.05, 0.05, 0.05});
  const FinderProblem problem = problem_of(human_hand(), object);
  const FoundGrasp grasp = grasp_of(problem);
  EXPECT_GE(grasp.travel_m, 20e-3);
  EXPECT_NEAR(grasp.travel_W.norm(), 1.0, 1e-12);
  EXPECT_GT(grasp.travel_friction, 0.0);
  EXPECT_LE(grasp.travel_friction, problem.cone_friction + 1e-6) << "the controller asks for no more";
  EXPECT_GT(grasp.travel_dexterity, kLeastDexterity);
}

TEST(Carry, EndsWhereJointsDo) {
  const ImplicitSurface object = box({0.05, 0.05, 0.05});
  const FoundGrasp grasp = grasp_of(problem_of(human_hand(), object));
  Hand stiff = human_hand();
  for (std::size_t i = 0; i < stiff.joints.size(); ++i) {
    stiff.joints[i].lower_rad = grasp.q[static_cast<Eigen::Index>(i)] - 1e-3;
    stiff.joints[i].upper_rad = grasp.q[static_cast<Eigen::Index>(i)] + 1e-3;
  }
  EXPECT_EQ(travel_of(problem_of(stiff, object), grasp).travel_m, 0.0);
}

// What drags at the object on its way must be borne, too. A drag of hundreds of newtons is borne by fingers that push,
// not by friction between those that press with 2 N: the way lies near the line on which they face each other.
TEST(Carry, GoesWhereTheDragIsBorne) {
  const ImplicitSurface object = box({0.05, 0.05, 0.05});
  FinderProblem problem = problem_of(human_hand(), object);
  FoundGrasp grasp = grasp_of(problem);
  problem.translation_damping = 1e4;
  grasp = travel_of(problem, grasp);
  const Eigen::Vector3d line_W = grasp.X_WO.linear() * grasp.places[grasp.opposer].normal_O;
  if (grasp.travel_m > 0.0) {
    EXPECT_GT(std::abs(grasp.travel_W.dot(line_W)), std::cos(std::atan(problem.cone_friction) + 0.05));
  }
}

}  // namespace
}  // namespace thenar::carry_test
