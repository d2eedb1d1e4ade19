// SPDX-License-Identifier: Apache-2.0
// What all sweeps share: which problems they admit, the local step, and the memory of the fast ones. They are run by
// the solver of gauss_seidel.h, whose laws gauss_seidel_test.cpp has.

#include "solvers/contact_sweeps.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "solvers/gauss_seidel.h"
#include "solvers/residual.h"
#include "tests/solvers/gauss_seidel_runs.h"
#include "tests/support/recorded_problems.h"

namespace thenar::contact_sweeps_test {
namespace {

using namespace gauss_seidel_runs;

using Eigen::Vector3d;

TEST_P(GaussSeidel, NotFiniteInputGivesZeros) {
  std::mt19937 random(1);
  const ContactData good = random_problem(6, random);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  const auto expect_refused = [](const ContactData& problem, const VectorXd& guess) {
    const Solution solution = solve(problem, {}, guess);
    EXPECT_EQ(solution.report.status, SolveStatus::kNotFinite);
    EXPECT_TRUE(solution.f.isZero(0.0));
    EXPECT_TRUE(solution.delta.isZero(0.0));
    EXPECT_TRUE(std::isinf(solution.report.residual)) << "no solution must not pass for a perfect one";
  };
  const VectorXd zero = VectorXd::Zero(18);
  for (const double bad : {nan, infinity, -infinity}) {
    ContactData problem = good;
    problem.delta_free[7] = bad;
    expect_refused(problem, zero);
    problem = good;
    problem.mu[2] = bad;
    expect_refused(problem, zero);
    problem = good;
    problem.W(4, 4) = bad;
    expect_refused(problem, zero);
    // Off the diagonal, in the column and row of a contact that carries force.
    Index loaded = 0;
    solve(good, {}).f.maxCoeff(&loaded);
    problem = good;
    problem.W.col(loaded).setConstant(bad);
    problem.W(loaded, loaded) = good.W(loaded, loaded);
    expect_refused(problem, zero);
    VectorXd guess = zero;
    guess[3] = bad;
    expect_refused(good, guess);
  }
  ContactData problem = good;
  problem.W(4, 4) = -good.W(4, 4);
  expect_refused(problem, zero);
  problem = good;
  problem.mu[3] = -0.1;
  expect_refused(problem, zero);
}

// Two bodies that nothing can move, as a held object against a wall: a gap stays as it is, and a penetration, too.
TEST_P(GaussSeidel, ContactsThatNoForceMoves) {
  std::mt19937 random(1);
  ContactData problem = random_problem(6, random);
  // The same without contact 2.
  ContactData rest{MatrixXd(15, 15), VectorXd(15), VectorXd(5)};
  rest.W << problem.W.topLeftCorner(6, 6), problem.W.topRightCorner(6, 9), problem.W.bottomLeftCorner(9, 6),
      problem.W.bottomRightCorner(9, 9);
  rest.delta_free << problem.delta_free.head(6), problem.delta_free.tail(9);
  rest.mu << problem.mu.head(2), problem.mu.tail(3);
  const GaussSeidelSettings settings{.tolerance = 1e-9, .max_sweeps = 20000};
  const Solution without = solve(rest, settings);
  problem.W.middleRows<3>(6).setZero();
  problem.W.middleCols<3>(6).setZero();
  problem.delta_free[6] = 1e-5;
  const Solution open = solve(problem, settings, VectorXd::Ones(18));
  EXPECT_EQ(open.report.status, SolveStatus::kConverged);
  EXPECT_TRUE(open.f.segment<3>(6).isZero(0.0));
  // W >= 1e-5 m/N makes a residual an error of about as much: some digits are left over.
  EXPECT_LE((open.f.head(6) - without.f.head(6)).norm(), 1e-6 * without.f.norm());
  EXPECT_LE((open.f.tail(9) - without.f.tail(9)).norm(), 1e-6 * without.f.norm());

  problem.delta_free[6] = -1e-5;
  const Solution pressed = solve(problem, settings);
  EXPECT_EQ(pressed.report.status, SolveStatus::kNoSolution);
  // The others have their forces all the same.
  EXPECT_LE((pressed.f - open.f).norm(), 1e-6 * open.f.norm());
}

// Where a solve begins near its answer it may be asked for a share of the first residual, within the tolerance. It is
// never left above the tolerance, and never goes on for digits that it was not asked for.
TEST_P(GaussSeidel, GoesOnBelowTheToleranceAsFarAsAsked) {
  std::mt19937 random(5);
  const ContactData problem = random_problem(8, random);
  const Solution exact = solve(problem, {.tolerance = 1e-12, .max_sweeps = 20000});
  for (const double off : {1e-2, 1e-4, 1e-6, 1e-8}) {
    SCOPED_TRACE(off);
    const VectorXd near = exact.f * (1.0 + off);
    const double tolerance = 1e-6;
    const double first = solve(problem, {.tolerance = 1.0, .max_sweeps = 0}, near).report.residual;
    const Solution plain = solve(problem, {.tolerance = tolerance, .max_sweeps = 20000}, near);
    const Solution finer =
        solve(problem, {.tolerance = tolerance, .max_sweeps = 20000, .share_of_first = 1e-2, .least_share = 0.1}, near);
    EXPECT_EQ(finer.report.status, SolveStatus::kConverged);
    EXPECT_LE(finer.report.residual, std::min(tolerance, std::max(1e-2 * first, 0.1 * tolerance)));
    EXPECT_GE(finer.report.sweeps, plain.report.sweeps);
    if (1e-2 * first >= tolerance) {
      EXPECT_EQ(finer.report.sweeps, plain.report.sweeps);
    }
  }
}

// A gap that only the normal force moves, W_tt = 0: whatever slips does so at the limit of friction.
TEST_P(GaussSeidel, SlipThatNoForceMoves) {
  const ContactData problem{Vector3d(1e-3, 0.0, 0.0).asDiagonal().toDenseMatrix(), Vector3d(-2e-3, 1e-3, 0.0),
                            VectorXd::Constant(1, 0.5)};
  const Solution solution = solve(problem, {.tolerance = 1e-12, .max_sweeps = 10});
  EXPECT_EQ(solution.report.status, SolveStatus::kConverged);
  EXPECT_LE((solution.f - Vector3d(2.0, -1.0, 0.0)).norm(), 1e-12);
}

// Problems outside of the requirements, and numbers at the ends of their range: an end, a status, forces in their
// cones.
TEST_P(GaussSeidel, AnyProblemEnds) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const ContactData good = random_problem(8, random);
    std::vector<ContactData> problems(7, good);
    problems[0].mu.setConstant(1e300);
    problems[1].W *= 1e-200;
    problems[2].W *= 1e+200;
    problems[3].W = 1e-5 * random_matrix(24, 24, random);  // neither symmetric nor definite
    problems[3].W.diagonal() = problems[3].W.diagonal().cwiseAbs().eval();
    problems[4].W = -good.W;
    problems[4].W.diagonal() = good.W.diagonal();
    problems[5].delta_free *= 1e-300;
    problems[6].delta_free *= 1e300;
    for (const ContactData& problem : problems) {
      const Solution solution = solve(problem, {.tolerance = 1e-9, .max_sweeps = 50});
      ASSERT_TRUE(solution.f.allFinite() && solution.delta.allFinite());
      EXPECT_FALSE(std::isnan(solution.report.residual) || std::isnan(solution.report.residual_worst));
      for (Index i = 0; i < 8; ++i) {
        EXPECT_GE(solution.f[3 * i], 0.0);
        EXPECT_LE(solution.f.segment<2>(3 * i + 1).stableNorm(), problem.mu[i] * solution.f[3 * i] * (1.0 + 1e-15));
      }
      if (solution.report.status == SolveStatus::kConverged) {
        EXPECT_LE(solution.report.residual, 1e-9);
      }
    }
  }
}

// Forces are as large as the free motion, whatever that is: single precision ends at 1e-45 and 3e38, doubles do not.
TEST_P(GaussSeidel, ScalesOfFreeMotionFarFromOne) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const ContactData good = random_problem(8, random);
    const GaussSeidelSettings settings{.tolerance = 1e-9, .max_sweeps = 20000};
    const Solution expected = solve(good, settings);
    // Inside of the range that single precision is trusted with, at its ends, and far outside.
    for (const double scale : {1e-60, 1e-45, 1e-25, 1e-15, 1e-12, 1e-9, 1e9, 1e12, 1e15, 1e25, 1e40, 1e60}) {
      SCOPED_TRACE(scale);
      ContactData scaled = good;
      scaled.delta_free *= scale;
      Solution solution = solve(scaled, settings);
      ASSERT_EQ(solution.report.status, SolveStatus::kConverged);
      solution.f /= scale;
      solution.delta /= scale;
      expect_laws(good, solution, settings.tolerance * (1.0 + 1e-6));  // both solvers round
      // W >= 1e-6 of its norm makes a residual an error of as many times it.
      EXPECT_LE((solution.f - expected.f).norm(), 1e-5 * expected.f.norm());
      // A guess that no float holds is none that forces cannot leave.
      solution = solve(scaled, settings, VectorXd::Constant(24, 1e40 * scale));
      EXPECT_TRUE(solution.f.allFinite() && solution.delta.allFinite());
      EXPECT_NE(solution.report.status, SolveStatus::kNotFinite);
    }
  }
}

// Where the residual's scale is no number, nothing can be told of forces: f = 0 must not pass for a solution of
// contacts that are pressed, though the sum of squares is zero.
TEST_P(GaussSeidel, AScaleThatFitsNoDoubleIsRefused) {
  for (const double scale : {1e-300, 1e-170, 1e-150, 1e170, 1e300}) {
    SCOPED_TRACE(scale);
    std::mt19937 random(1);
    ContactData problem = random_problem(8, random);
    problem.delta_free *= scale;
    const Solution solution = solve(problem, {});
    EXPECT_EQ(solution.report.status, SolveStatus::kNotFinite);
    EXPECT_TRUE(solution.f.isZero(0.0) && solution.delta.isZero(0.0));
    EXPECT_TRUE(std::isinf(solution.report.residual));
    EXPECT_TRUE(std::isinf(natural_map(problem, VectorXd::Zero(24), problem.delta_free).norm));
  }
}

TEST_P(GaussSeidel, SameProblemSameBits) {
  std::mt19937 random(5);
  const ContactData problem = random_problem(25, random);
  const ContactData other = random_problem(12, random);
  SweepWorkspace work(25);
  VectorXd f_1 = VectorXd::Zero(75), f_2 = f_1, f_other = VectorXd::Zero(36), delta(75);
  const GaussSeidelSettings settings{.tolerance = 1e-7, .max_sweeps = 500};
  (void)solve_contacts(problem, settings, work, {f_1, delta});
  (void)solve_contacts(other, settings, work, {f_other, delta.head(36)});
  (void)solve_contacts(problem, settings, work, {f_2, delta});
  EXPECT_EQ(f_1, f_2);  // What a workspace was used for before leaves no trace.
}

// What the acceleration is there for. Counts, not times: plain sweeps take about twice as many on these.
TEST(FastSweeps, AreFewer) {
  int plain_sweeps = 0, fast_sweeps = 0;
  for (const ContactFile& recorded : recorded_contact_problems()) {
    const GaussSeidelSettings settings{.tolerance = 1e-6, .max_sweeps = 2000};
    SweepWorkspace work(recorded.contacts());
    VectorXd f = VectorXd::Zero(3 * recorded.contacts()), delta(f.size());
    plain_sweeps += solve_contacts(recorded.problem(), settings, {f, delta}).sweeps;
    f.setZero();
    fast_sweeps += solve_contacts(recorded.problem(), settings, work, {f, delta}).sweeps;
  }
  EXPECT_LT(fast_sweeps, 0.7 * plain_sweeps);
}

}  // namespace
}  // namespace thenar::contact_sweeps_test
