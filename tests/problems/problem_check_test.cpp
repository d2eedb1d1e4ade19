// SPDX-License-Identifier: Apache-2.0
// What an answer is worth: nothing is missed, and what is wrong is missed by as much as it is wrong.

#include "engine/problems/problem_check.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "tests/support/algebra.h"
#include "tests/support/nnls.h"
#include "tests/support/recorded_problems.h"

namespace thenar::problem_check_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

template <typename File>
std::vector<File> recorded_small_files() {
  std::vector<File> problems;
  for (const auto& file : data_files("small")) {
    ProblemFile problem = read_problem(file);
    if (std::holds_alternative<File>(problem)) problems.push_back(std::get<File>(std::move(problem)));
  }
  EXPECT_FALSE(problems.empty());
  return problems;
}

TEST(ProblemCheck, ReferenceContactForcesHaveTheResidualThatTheirFilesState) {
  for (const ContactFile& problem : recorded_contact_problems()) {
    const Residual residual = contact_residual(problem.problem(), problem.f_reference);
    // The file states three digits of a number that is itself rounding where it is this small.
    EXPECT_LE(residual.norm, 2.0 * problem.reference_residual + 1e-14) << problem.name;
    EXPECT_LE(residual.worst, residual.norm) << problem.name;
    EXPECT_GE(residual.worst, residual.norm / std::sqrt(static_cast<double>(problem.contacts()))) << problem.name;
  }
}

// It has no unit, so other units change nothing, also where squares of such numbers do not fit a double.
TEST(ProblemCheck, TheContactResidualIsTheSameInAnyUnit) {
  ContactFile problem = recorded_contact_problems().front();
  const VectorXd f = 0.9 * problem.f_reference;
  const double residual = contact_residual(problem.problem(), f).norm;
  for (const double m_per_unit : {1e-250, 1e250}) {
    ContactFile scaled = problem;
    scaled.W *= m_per_unit;
    scaled.delta_free.front() *= m_per_unit;
    EXPECT_NEAR(contact_residual(scaled.problem(), f).norm, residual, 1e-12 * residual);
  }
}

// Without forces the natural map is P_K of minus the scaled free gaps: all of it where they are closed and do not slip.
TEST(ProblemCheck, NoForcesOnClosedGapsAreWrongByTheWholeScale) {
  ContactData problem{MatrixXd::Identity(6, 6), VectorXd::Zero(6), VectorXd::Constant(2, 0.5)};
  problem.delta_free[0] = -3e-3;
  problem.delta_free[3] = -4e-3;
  const Residual residual = contact_residual(problem, VectorXd::Zero(6));
  EXPECT_NEAR(residual.norm, 1.0, 1e-15);
  EXPECT_NEAR(residual.worst, 0.8, 1e-15);
}

// Two contacts press a rigid body from both sides: what the gaps lack in sum, no force can give.
TEST(ProblemCheck, OpposedContactsOnARigidBodyProveThatThereAreNoForces) {
  Eigen::Matrix<double, 6, 3> J;  // rows n, t1, t2 of both; the normals oppose each other
  J << 1, 0, 0, 0, 1, 0, 0, 0, 1, -1, 0, 0, 0, 1, 0, 0, 0, -1;
  ContactData problem{1e-3 * J * J.transpose(), VectorXd::Zero(6), VectorXd::Constant(2, 0.5)};
  problem.delta_free[0] = -1e-3;
  problem.delta_free[3] = 0.25e-3;
  VectorXd y = VectorXd::Ones(2);
  const ContactVerdict proved = contact_verdict(problem, y);
  EXPECT_LE(proved.gap, 1e-15);
  EXPECT_NEAR(proved.closed_m, 0.75e-3, 1e-18);
  // Something moves: W y = 1e-3 * 0.1 m/N against gaps closed by 0.775e-3 m.
  y[0] = 1.1;
  EXPECT_GT(contact_verdict(problem, y).gap, kProvedGap);
  // A pull proves nothing, and open gaps neither.
  y = -y;
  EXPECT_EQ(contact_verdict(problem, y).gap, std::numeric_limits<double>::infinity());
  problem.delta_free[3] = 2e-3;
  EXPECT_EQ(contact_verdict(problem, VectorXd::Ones(2)).gap, std::numeric_limits<double>::infinity());
}

// Only contacts that are nearly on a line lose digits; on a line, what they cannot do at all is not asked of them.
TEST(ProblemCheck, GraspsLoseDigitsNearALine) {
  for (const GraspFile& problem : recorded_small_files<GraspFile>()) {
    const bool is_near_line = problem.name == "near_collinear";
    const double rounding = grasp_rounding(problem.problem(FrictionCone::kPyramid));
    EXPECT_LE(rounding, is_near_line ? 1e-8 : 1e-14) << problem.name;
    EXPECT_GE(rounding, is_near_line ? 1e-10 : 0.0) << problem.name;
  }
}

TEST(ProblemCheck, MuscleForcesAreWrongByWhatCouldBeSaved) {
  int checked = 0;
  for (const MuscleFile& problem : recorded_small_files<MuscleFile>()) {
    if (problem.status != "optimal") continue;
    // The reference is exact to a double; H's condition is about 10.
    EXPECT_LE(muscle_residual(problem, problem.f_optimal), 1e-13);

    // A torque-free change d of the muscles that pull: no multiplier of a resting muscle, and no H'l, balances it, for
    // both are at right angles to d. So exactly |d| is wrong.
    std::vector<Index> pulling;
    for (Index i = 0; i < problem.f_optimal.size(); ++i) {
      if (problem.f_optimal[i] > 1e-9) pulling.push_back(i);
    }
    const MatrixXd null = null_space(problem.H(Eigen::all, pulling));
    ASSERT_GT(null.norm(), 0.0);
    VectorXd d = VectorXd::Zero(problem.H.cols());
    d(pulling) = 1e-5 * null.col(0).normalized();
    const VectorXd wrong = problem.f_optimal.cwiseMax(0.0) + d;
    EXPECT_NEAR(muscle_residual(problem, wrong), 1e-5 / wrong.norm(), 1e-13);

    // Missing torque: the least forces that would give it. A push: as it is.
    const VectorXd scaled = 1.001 * problem.f_optimal;
    const double least = least_squares(problem.H, 1e-3 * problem.tau).norm();
    EXPECT_GE(muscle_residual(problem, scaled), (1.0 - 1e-9) * least / scaled.norm());
    VectorXd pushing = problem.f_optimal;
    pushing[0] = -1e-3;
    EXPECT_GE(muscle_residual(problem, pushing), 1e-3 / pushing.norm());
    ++checked;
  }
  EXPECT_GT(checked, 0);
}

TEST(ProblemCheck, MusclesLackWhatLiesBesideTheirCone) {
  for (const MuscleFile& problem : recorded_small_files<MuscleFile>()) {
    const MuscleDeficit deficit = explain_infeasible_muscles(problem);
    const double distance_Nm = distance_from_cone(problem.H, problem.tau);
    EXPECT_NEAR(deficit.missing_Nm.norm(), distance_Nm, 1e-10 * problem.tau.norm()) << problem.name;
    if (problem.status == "infeasible") {
      EXPECT_LE(deficit.gap, kProvedGap);
    } else {
      // There are forces, and so no proof: the gap is at least as large as they allow.
      const VectorXd least = least_squares(problem.H, problem.tau);
      EXPECT_GE(deficit.gap, 0.99 * least.norm() / problem.f_optimal.norm()) << problem.name;
    }
  }
}

TEST(ProblemCheck, LcpAnswersAreHeldAgainstTheProblem) {
  for (const LcpFile& problem : recorded_small_files<LcpFile>()) {
    if (problem.z.size() == 0) continue;
    EXPECT_LE(lcp_residual(problem, problem.z), 1e-15) << problem.name;
  }
  // w = 2 z - 1 at z = 0.4: w = -0.2 over the terms 1 + 2 * 0.4.
  const LcpData one{MatrixXd::Constant(1, 1, 2.0), VectorXd::Constant(1, -1.0)};
  EXPECT_NEAR(lcp_residual(one, VectorXd::Constant(1, 0.4)), 0.2 / 1.8, 1e-15);
  EXPECT_EQ(lcp_infeasibility_gap(one, VectorXd::Ones(1)), 1.0) << "z = 1/2 solves it: 2 * 1/2 over 1";
  const LcpData none{MatrixXd::Constant(1, 1, -1.0), VectorXd::Constant(1, -1.0)};
  EXPECT_EQ(lcp_infeasibility_gap(none, VectorXd::Ones(1)), 0.0);
  EXPECT_EQ(lcp_infeasibility_gap(none, -VectorXd::Ones(1)), std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace thenar::problem_check_test
