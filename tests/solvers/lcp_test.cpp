// SPDX-License-Identifier: Apache-2.0
#include "solvers/lcp.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "tests/support/allocation_counter.h"
#include "tests/support/json_eigen.h"

namespace thenar::lcp_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Solution {
  LcpReport report;
  VectorXd z;
};

Solution solve(const LcpData& lcp, int max_pivots = 1000) {
  LcpWorkspace work(lcp.q.size());
  VectorXd z(lcp.q.size());
  const LcpReport report = solve_lcp(lcp, max_pivots, work, z);
  return {report, z};
}

MatrixXd random_matrix(Index rows, Index cols, std::mt19937& random) {
  std::normal_distribution<double> normal;
  return MatrixXd::NullaryExpr(rows, cols, [&] { return normal(random); });
}

VectorXd random_positive(Index n, std::mt19937& random) { return random_matrix(n, 1, random).cwiseAbs(); }

/// Complementarity, relative to the size of the terms. A dozen pivots on entries of order 1 amplify rounding (1e-16) by
/// their growth, which stayed below 1e4 over these seeds; a wrong basis is off by order 1.
void expect_solution(const LcpData& lcp, const VectorXd& z, double tolerance = 1e-9) {
  const VectorXd w = lcp.M * z + lcp.q;
  const double w_scale = lcp.q.cwiseAbs().maxCoeff() + (lcp.M.cwiseAbs() * z).maxCoeff();
  EXPECT_GE(z.minCoeff(), 0.0);
  EXPECT_GE(w.minCoeff(), -tolerance * w_scale);
  EXPECT_LE((w.array() * z.array()).abs().maxCoeff(), tolerance * w_scale * (z.maxCoeff() + 1e-300));
}

/// z >= 0, M z = 0, q.z < 0: then no w = M y + q >= 0 exists, because z.w = q.z for every y (M symmetric).
void expect_infeasibility_certificate(const LcpData& lcp, const VectorXd& z) {
  EXPECT_GE(z.minCoeff(), 0.0);
  EXPECT_NEAR(z.maxCoeff(), 1.0, 1e-15);
  EXPECT_LE((lcp.M * z).cwiseAbs().maxCoeff(), 1e-9 * lcp.M.cwiseAbs().maxCoeff());
  EXPECT_LT(lcp.q.dot(z), 0.0);
}

TEST(Lcp, SolvesRecordedProblems) {
  for (const auto& problem : recorded_small_problems("LCP")) {
    SCOPED_TRACE(problem.at("file"));
    const LcpData lcp{matrix_of(problem.at("M")), vector_of(problem.at("q"))};
    const Solution solution = solve(lcp);
    ASSERT_EQ(solution.report.status, LcpStatus::kSolved);
    expect_solution(lcp, solution.z);
    // z is unique but for the singular problem, where the file has the basic solution on Lemke's path, as found here.
    // Entries are small integers: no rounding but of 1/3.
    EXPECT_LE((solution.z - vector_of(problem.at("z"))).cwiseAbs().maxCoeff(), 1e-15);
  }
}

// Murty's family: M = 1 on the diagonal, 2 below, q = -1. Lemke's path visits all 2^n bases, so a budget is needed.
TEST(Lcp, MurtysFamilyTakesExponentiallyManyPivots) {
  for (const Index n : {3, 6, 8}) {
    const MatrixXd lower = MatrixXd(MatrixXd::Constant(n, n, 2.0).triangularView<Eigen::StrictlyLower>());
    const LcpData lcp{lower + MatrixXd::Identity(n, n), VectorXd::Constant(n, -1.0)};
    const Solution solution = solve(lcp);
    EXPECT_EQ(solution.report.status, LcpStatus::kSolved);
    EXPECT_EQ(solution.report.pivots, 1 << n);
    expect_solution(lcp, solution.z);

    const Solution cut_short = solve(lcp, (1 << n) - 1);
    EXPECT_EQ(cut_short.report.status, LcpStatus::kBudgetSpent);
    EXPECT_EQ(cut_short.report.pivots, (1 << n) - 1);
    EXPECT_TRUE(cut_short.z.isZero(0.0));
  }
}

TEST(Lcp, MurtysFamilyEndsAtTheUsualBudget) {
  constexpr Index n = 15;  // 32768 pivots; the LCP of three contacts is as large.
  const MatrixXd lower = MatrixXd(MatrixXd::Constant(n, n, 2.0).triangularView<Eigen::StrictlyLower>());
  const LcpData lcp{lower + MatrixXd::Identity(n, n), VectorXd::Constant(n, -1.0)};
  const Solution solution = solve(lcp, usual_pivot_budget(n));
  EXPECT_EQ(solution.report.status, LcpStatus::kBudgetSpent);
  EXPECT_EQ(solution.report.pivots, usual_pivot_budget(n));
  EXPECT_TRUE(solution.z.isZero(0.0));
}

// A P-matrix on which Bard's principal pivoting and projected Gauss-Seidel cycle. By hand: z = 1/3 in all rows, w = 0.
TEST(Lcp, CirculantThreeByThree) {
  const LcpData lcp{Eigen::Matrix3d{{1.0, 2.0, 0.0}, {0.0, 1.0, 2.0}, {2.0, 0.0, 1.0}}, VectorXd::Constant(3, -1.0)};
  const Solution solution = solve(lcp);
  ASSERT_EQ(solution.report.status, LcpStatus::kSolved);
  // Rounding of a third.
  EXPECT_LE((solution.z.array() - 1.0 / 3.0).abs().maxCoeff(), 1e-15);
}

// M = B B' of rank 1 to n, q = w - M z with known w, z: a solution exists. z need not be unique, w is.
TEST(Lcp, SolvesFeasibleSemiDefiniteProblems) {
  for (unsigned seed = 0; seed < 400; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const Index n = 2 + seed % 24;
    const MatrixXd B = random_matrix(n, 1 + seed % n, random);
    VectorXd z = random_positive(n, random);
    VectorXd w = random_positive(n, random);
    for (Index i = 0; i < n; ++i) (random() % 2 == 0 ? z : w)[i] = 0.0;
    const LcpData lcp{B * B.transpose(), w - B * (B.transpose() * z)};

    const Solution solution = solve(lcp);
    ASSERT_EQ(solution.report.status, LcpStatus::kSolved);
    expect_solution(lcp, solution.z);
    const VectorXd w_found = lcp.M * solution.z + lcp.q;
    // |B'(z_found - z)|^2 = the complementarity error: its square root limits how well w is known.
    EXPECT_LE((w_found - w).cwiseAbs().maxCoeff(), 1e-5 * (1.0 + lcp.q.cwiseAbs().maxCoeff()));
  }
}

// Whatever the answer on a random right side, it comes with a proof.
TEST(Lcp, EveryAnswerOnSemiDefiniteProblemsHasItsCertificate) {
  int infeasible = 0;
  for (unsigned seed = 0; seed < 400; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const Index n = 3 + seed % 20;
    const MatrixXd B = random_matrix(n, 1 + n / 2, random);
    const LcpData lcp{B * B.transpose(), random_matrix(n, 1, random)};
    const Solution solution = solve(lcp);
    ASSERT_NE(solution.report.status, LcpStatus::kBudgetSpent);
    if (solution.report.status == LcpStatus::kSolved) {
      expect_solution(lcp, solution.z);
    } else {
      ++infeasible;
      expect_infeasibility_certificate(lcp, solution.z);
    }
  }
  // Else this test would say nothing about rays.
  EXPECT_GT(infeasible, 20);
}

// Entries of few values: many rows tie in every ratio test, where a rule without lexicographic order can cycle.
TEST(Lcp, TiedRatiosDoNotCycle) {
  for (unsigned seed = 0; seed < 400; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const Index n = 4 + seed % 12;
    const MatrixXd B = MatrixXd::NullaryExpr(n, 1 + n / 2, [&] { return static_cast<double>(random() % 3) - 1.0; });
    const LcpData lcp{B * B.transpose(), VectorXd::NullaryExpr(n, [&] { return -static_cast<double>(random() % 2); })};
    const Solution solution = solve(lcp);
    ASSERT_NE(solution.report.status, LcpStatus::kBudgetSpent);
    if (solution.report.status == LcpStatus::kSolved) {
      expect_solution(lcp, solution.z);
    } else {
      expect_infeasibility_certificate(lcp, solution.z);
    }
  }
}

// A change of units scales z and nothing else. Powers of two: not even rounding changes.
TEST(Lcp, AnswerDoesNotDependOnUnits) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const MatrixXd B = random_matrix(12, 7, random);
    const LcpData lcp{B * B.transpose(), random_matrix(12, 1, random)};
    const Solution solution = solve(lcp);
    const Solution scaled = solve({std::ldexp(1.0, 40) * lcp.M, std::ldexp(1.0, -30) * lcp.q});
    EXPECT_EQ(scaled.report.status, solution.report.status);
    EXPECT_EQ(scaled.report.pivots, solution.report.pivots);
    if (solution.report.status == LcpStatus::kSolved) {
      EXPECT_EQ(std::ldexp(1.0, 70) * scaled.z, solution.z);
    }
  }
}

TEST(Lcp, NonNegativeRightSideNeedsNoPivot) {
  const Solution solution = solve({MatrixXd::Identity(3, 3), VectorXd::Unit(3, 1)});
  EXPECT_EQ(solution.report.status, LcpStatus::kSolved);
  EXPECT_EQ(solution.report.pivots, 0);
  EXPECT_TRUE(solution.z.isZero(0.0));
  EXPECT_EQ(solve({MatrixXd(0, 0), VectorXd(0)}).report.status, LcpStatus::kSolved);
}

TEST(Lcp, ZeroMatrixIsInfeasibleForANegativeRightSide) {
  const LcpData lcp{MatrixXd::Zero(3, 3), -VectorXd::Unit(3, 1)};
  const Solution solution = solve(lcp);
  EXPECT_EQ(solution.report.status, LcpStatus::kInfeasible);
  EXPECT_EQ(solution.z, VectorXd::Unit(3, 1));
}

TEST(Lcp, NotFiniteInputGivesZeros) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    LcpData lcp{MatrixXd::Identity(3, 3), VectorXd::Constant(3, -1.0)};
    lcp.q[1] = bad;
    EXPECT_EQ(solve(lcp).report.status, LcpStatus::kBudgetSpent);
    EXPECT_TRUE(solve(lcp).z.isZero(0.0));
    lcp.q[1] = -1.0;
    lcp.M(2, 0) = bad;
    EXPECT_EQ(solve(lcp).report.status, LcpStatus::kBudgetSpent);
    EXPECT_TRUE(solve(lcp).z.isZero(0.0));
  }
}

TEST(Lcp, DoesNotAllocate) {
  if (!AllocationCounter::is_available()) GTEST_SKIP() << "malloc is not ours";
  std::mt19937 random(1);
  const MatrixXd B = random_matrix(40, 20, random);
  const MatrixXd M = B * B.transpose();
  const VectorXd q = M * random_positive(40, random) - random_positive(40, random);
  LcpWorkspace work(40);
  VectorXd z(40);
  for (const Index n : {40, 15, 23}) {
    const AllocationCounter counter;
    const LcpReport report = solve_lcp({M.topLeftCorner(n, n), q.head(n)}, 1000, work, z.head(n));
    EXPECT_EQ(counter.count(), 0);
    EXPECT_GT(report.pivots, 0);
  }
}

// The counter itself: else a count of zero would prove nothing.
TEST(AllocationCounter, SeesMallocNewAndEigen) {
  if (!AllocationCounter::is_available()) GTEST_SKIP() << "malloc is not ours";
  const AllocationCounter counter;
  const VectorXd eigen = VectorXd::Zero(100);
  EXPECT_EQ(counter.count(), 1);
  const std::vector<double> standard(100);
  EXPECT_EQ(counter.count(), 2);
}

}  // namespace
}  // namespace thenar::lcp_test
