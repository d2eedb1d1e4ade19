#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <vector>

#include "solvers/muscle_forces.h"
#include "tests/allocation_counter.h"
#include "tests/json_eigen.h"
#include "tests/nnls.h"

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Solution {
  MuscleReport report;
  VectorXd f;
};

Solution solve(const MatrixXd& H, const VectorXd& tau) {
  MuscleWorkspace work(H.rows(), H.cols());
  VectorXd f = VectorXd::Constant(H.cols(), std::numeric_limits<double>::quiet_NaN());
  const MuscleReport report = solve_muscle_forces(H, tau, work, f);
  return {report, f};
}

MatrixXd random_matrix(Index rows, Index cols, std::mt19937& random) {
  std::normal_distribution<double> normal;
  return MatrixXd::NullaryExpr(rows, cols, [&] { return normal(random); });
}

/// Lever arms of about 1 cm.
MatrixXd random_arms(std::mt19937& random) { return 0.01 * random_matrix(12, 23, random); }

/// Karush-Kuhn-Tucker. Lever arms of 1 cm and forces of newtons: torques round at 1e-18 a term, and a condition number
/// of H of 100 leaves 1e-12 of the forces' size. A muscle counts as slack below 1e-9 of it.
void expect_optimal(const MatrixXd& H, const VectorXd& tau, const Solution& solution) {
  const VectorXd& f = solution.f;
  const double size_N = 1.0 + f.norm();
  EXPECT_GE(f.minCoeff(), 0.0);
  EXPECT_LE((H * f - tau).cwiseAbs().maxCoeff(), 1e-12 * size_N);
  EXPECT_NEAR(solution.report.residual_Nm, (H * f - tau).cwiseAbs().maxCoeff(), 1e-15 * size_N);
  std::vector<Index> slack;
  for (Index j = 0; j < f.size(); ++j) {
    if (f[j] < 1e-9 * size_N) slack.push_back(j);
  }
  const MatrixXd identity = MatrixXd::Identity(f.size(), f.size());
  EXPECT_LE(stationarity_error(f, H, identity(slack, Eigen::all)), 1e-8 * size_N);
}

TEST(MuscleForces, AgreeWithTheRecordedOptima) {
  for (const auto& problem : recorded_small_problems("P2")) {
    SCOPED_TRACE(problem.at("file"));
    const MatrixXd H = matrix_of(problem.at("H"));
    const VectorXd tau = vector_of(problem.at("tau"));
    const Solution solution = solve(H, tau);
    if (problem.at("status") == "infeasible") {
      EXPECT_EQ(solution.report.status, MuscleStatus::kInfeasible);
      EXPECT_TRUE(solution.f.hasNaN()) << "f must be left as it was";
      continue;
    }
    ASSERT_EQ(solution.report.status, MuscleStatus::kOptimal);
    // Forces of 60 to 200 N: 1e-11 of them.
    EXPECT_LE((solution.f - vector_of(problem.at("f_opt"))).cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_LE(solution.report.residual_Nm, 1e-12);
  }
}

TEST(MuscleForces, AgreeWithTheHandsReference) {
  const nlohmann::json hand = read_json(THENAR_TEST_DATA "/hand_reference.json");
  const MatrixXd H = matrix_of(hand.at("H"));
  for (const auto& problem : hand.at("muscle")) {
    const VectorXd tau = vector_of(problem.at("tau"));
    const Solution solution = solve(H, tau);
    if (problem.at("f").is_null()) {
      EXPECT_EQ(solution.report.status, MuscleStatus::kInfeasible);
      continue;
    }
    ASSERT_EQ(solution.report.status, MuscleStatus::kOptimal);
    EXPECT_LE((solution.f - vector_of(problem.at("f"))).cwiseAbs().maxCoeff(), 1e-10);
    expect_optimal(H, tau, solution);
  }
}

// Random arms often cannot pull every way: both answers occur, and both are proved.
TEST(MuscleForces, EveryAnswerIsProved) {
  int infeasible = 0;
  for (unsigned seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const MatrixXd H = random_arms(random);
    const VectorXd tau = 0.1 * random_matrix(12, 1, random);
    const Solution solution = solve(H, tau);
    ASSERT_NE(solution.report.status, MuscleStatus::kBudgetSpent);
    // In units of 1 cm, so that the oracle's zero fits.
    const double out_of_reach = distance_from_cone(100.0 * H, 100.0 * tau);
    if (solution.report.status == MuscleStatus::kOptimal) {
      expect_optimal(H, tau, solution);
      EXPECT_LE(out_of_reach, 1e-9);
    } else {
      ++infeasible;
      EXPECT_GE(out_of_reach, 1e-9);
    }
  }
  EXPECT_GT(infeasible, 30);
  EXPECT_LT(infeasible, 270);
}

// Two muscles that pull apart on one joint: only the agonist works. A third of the same arm halves it.
TEST(MuscleForces, OfOneJointByHand) {
  MatrixXd H(1, 3);
  H << 0.01, -0.01, 0.01;
  const Solution flexion = solve(H, VectorXd::Constant(1, 0.2));
  EXPECT_LE((flexion.f - Eigen::Vector3d(10.0, 0.0, 10.0)).cwiseAbs().maxCoeff(), 1e-13);
  const Solution extension = solve(H, VectorXd::Constant(1, -0.2));
  EXPECT_LE((extension.f - Eigen::Vector3d(0.0, 20.0, 0.0)).cwiseAbs().maxCoeff(), 1e-13);
}

TEST(MuscleForces, AreZeroWithoutTorque) {
  std::mt19937 random(1);
  const Solution solution = solve(random_arms(random), VectorXd::Zero(12));
  EXPECT_EQ(solution.report.status, MuscleStatus::kOptimal);
  EXPECT_TRUE(solution.f.isZero(0.0));
}

// A joint whose arms repeat those of others adds nothing if its torque agrees, and cannot be had if not.
TEST(MuscleForces, DependentJointsAreTakenOrRefused) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    MatrixXd H = random_arms(random);
    H.row(5) = H.row(1) - 2.0 * H.row(3);
    H.row(11).setZero();
    const VectorXd tau = H * random_matrix(23, 1, random).cwiseAbs();
    const Solution solution = solve(H, tau);
    ASSERT_EQ(solution.report.status, MuscleStatus::kOptimal);
    expect_optimal(H, tau, solution);
    for (const Index joint : {5, 11}) {
      EXPECT_EQ(solve(H, tau + 0.01 * VectorXd::Unit(12, joint)).report.status, MuscleStatus::kInfeasible);
    }
  }
}

TEST(MuscleForces, NotFiniteInputIsRefused) {
  std::mt19937 random(1);
  MatrixXd H = random_arms(random);
  VectorXd tau = VectorXd::Constant(12, 0.1);
  tau[3] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(solve(H, tau).report.status, MuscleStatus::kBudgetSpent);
  tau[3] = 0.0;
  H(2, 2) = std::numeric_limits<double>::infinity();
  EXPECT_EQ(solve(H, tau).report.status, MuscleStatus::kBudgetSpent);
}

TEST(MuscleForces, DoNotAllocate) {
  if (!AllocationCounter::is_available()) GTEST_SKIP() << "malloc is not ours";
  std::mt19937 random(1);
  const MatrixXd H = random_arms(random);
  const VectorXd tau = H * random_matrix(23, 1, random).cwiseAbs();
  MuscleWorkspace work(12, 23);
  VectorXd f(23);
  const AllocationCounter counter;
  const MuscleReport report = solve_muscle_forces(H, tau, work, f);
  EXPECT_EQ(counter.count(), 0);
  EXPECT_EQ(report.status, MuscleStatus::kOptimal);
}

}  // namespace
}  // namespace thenar
