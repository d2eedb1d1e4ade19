// SPDX-License-Identifier: Apache-2.0
#include "engine/finder/effort.h"

#include <gtest/gtest.h>

#include "engine/grasp/frame.h"
#include "tests/finder/known_surfaces.h"

namespace thenar::effort_test {
namespace {

using namespace known_surfaces;
using Eigen::Vector3d;

struct Held {
  FoundGrasp grasp;
  std::vector<GraspContact> contacts;
};

/// The contacts of a grasp, world axes.
std::vector<GraspContact> contacts_of(const FoundGrasp& grasp) {
  std::vector<GraspContact> contacts;
  for (const FingerPlace& place : grasp.places) {
    const Vector3d n = -(grasp.X_WO.linear() * place.normal_O);
    contacts.push_back({grasp.X_WO * place.point_O, axes_of(n, n.unitOrthogonal())});
  }
  return contacts;
}

Held held(const FinderProblem& problem) {
  const FinderReport report = find_grasps(problem);
  EXPECT_EQ(report.grasps.size(), 1U);
  return {report.grasps.front(), contacts_of(report.grasps.front())};
}

TEST(Directions, AreFourteenUnlikeUnitVectorsWithoutAMean) {
  const std::vector<Vector3d> all = directions();
  ASSERT_EQ(all.size(), 14U);
  Vector3d sum = Vector3d::Zero();
  for (const Vector3d& e : all) {
    EXPECT_NEAR(e.norm(), 1.0, 1e-15);
    sum += e;
  }
  EXPECT_LT(sum.norm(), 1e-14);
}

// Forces against a push and a turn balance them, to the solver's rounding, within the cones.
TEST(ForceCheck, BalancesWhatPulls) {
  const ImplicitSurface object = box({0.04, 0.05, 0.06});
  FinderProblem problem = problem_of(human_hand(), object);
  problem.centre_of_mass_m = Vector3d(2e-3, -3e-3, 5e-3);
  const auto [grasp, contacts] = held(problem);
  ForceCheck check(problem, contacts, grasp.X_WO, 2.0);
  const Vector3d push_N(0.3, -0.5, 0.2), turn_Nm(2e-3, 1e-3, -3e-3);
  const HoldingForces forces = check.against(push_N, turn_Nm);
  ASSERT_TRUE(forces.found);
  EXPECT_LE(forces.needed_friction, problem.cone_friction * (1.0 + 1e-6));
  Vector3d force = push_N, moment = turn_Nm;
  for (int k = 0; k < 3; ++k) {
    const Vector3d f = forces.f.segment<3>(3 * k);
    force += f;
    moment += (contacts[k].point_m - grasp.X_WO * problem.centre_of_mass_m).cross(f);
  }
  EXPECT_LT(force.norm(), 1e-9);
  EXPECT_LT(moment.norm(), 1e-11);
  EXPECT_FALSE(check.against(1e4 * push_N, Vector3d::Zero()).found && problem.cone_friction < 0.1);
}

// tau' dq is the work of the contact forces on their points, by differences of the kinematics: central ones err by the
// square of the step.
TEST(Effort, HasTheTorquesOfVirtualWork) {
  const ImplicitSurface object = box({0.04, 0.05, 0.06});
  FinderProblem problem = problem_of(human_hand(), object);
  problem.gravity.setZero();  // fingers have no weight here
  const auto [grasp, contacts] = held(problem);
  const Eigen::VectorXd f = Eigen::VectorXd::LinSpaced(9, -1.0, 2.0);
  Effort effort(problem, human_hand(), contacts, Eigen::Isometry3d::Identity());
  const JointVector tau = effort.torques_Nm(grasp.q, f);
  constexpr double kStep = 1e-5;
  HandPose start, up, down;
  forward_kinematics(human_hand(), grasp.q, start);
  for (Eigen::Index i = 0; i < tau.size(); ++i) {
    JointVector q = grasp.q;
    q[i] += kStep;
    forward_kinematics(human_hand(), q, up);
    q[i] -= 2.0 * kStep;
    forward_kinematics(human_hand(), q, down);
    double work = 0.0;
    for (int k = 0; k < 3; ++k) {
      const Vector3d p_F = start.distal(human_hand(), k).inverse() * contacts[k].point_m;
      const Vector3d way = up.distal(human_hand(), k) * p_F - down.distal(human_hand(), k) * p_F;
      work += way.dot(f.segment<3>(3 * k)) / (2.0 * kStep);
    }
    EXPECT_NEAR(tau[i], work, 1e-9) << i;
  }
  EXPECT_EQ(effort.muscle_share(tau), 0.0) << "torques drive the joints";
}

}  // namespace
}  // namespace thenar::effort_test
