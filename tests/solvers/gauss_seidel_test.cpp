// SPDX-License-Identifier: Apache-2.0
#include "solvers/gauss_seidel.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "solvers/lcp.h"
#include "tests/solvers/gauss_seidel_runs.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/recorded_problems.h"

namespace thenar::gauss_seidel_test {
namespace {

using namespace gauss_seidel_runs;

using Eigen::Matrix3d;
using Eigen::Vector3d;

INSTANTIATE_TEST_SUITE_P(Sweeps, GaussSeidel, testing::Bool(),
                         [](const auto& sweeps) { return sweeps.param ? "Fast" : "Plain"; });

ContactData problem_of(const ContactFile& recorded, std::size_t step = 0) {
  return {recorded.W, recorded.delta_free[step], recorded.mu};
}

void expect_inside_cones(const ContactData& problem, const VectorXd& f) {
  ASSERT_TRUE(f.allFinite());
  for (Index i = 0; i < problem.contacts(); ++i) {
    EXPECT_GE(f[3 * i], 0.0);
    EXPECT_LE(f.segment<2>(3 * i + 1).norm(), problem.mu[i] * f[3 * i] * (1.0 + 1e-15));
  }
}

/// The gaps returned are those of the forces returned; terms are as large as the free motion, 180 of them add up.
void expect_gaps_of_forces(const ContactData& problem, const Solution& solution) {
  const VectorXd delta = problem.W * solution.f + problem.delta_free;
  const double size_m = (problem.W.cwiseAbs() * solution.f.cwiseAbs() + problem.delta_free.cwiseAbs()).maxCoeff();
  EXPECT_LE((solution.delta - delta).cwiseAbs().maxCoeff(), 1e-14 * size_m);
}

TEST_P(GaussSeidel, SolvesTheRecordedProblemsFromRest) {
  for (const ContactFile& recorded : recorded_contact_problems()) {
    SCOPED_TRACE(recorded.name);
    const ContactData problem = problem_of(recorded);
    const GaussSeidelSettings settings{.tolerance = 1e-8, .max_sweeps = 2000};
    const Solution solution = solve(problem, settings);
    ASSERT_EQ(solution.report.status, SolveStatus::kConverged);
    EXPECT_LE(solution.report.residual, settings.tolerance);
    expect_laws(problem, solution, settings.tolerance);
    expect_gaps_of_forces(problem, solution);
  }
}

TEST_P(GaussSeidel, FollowsTheRecordedSequencesFromTheLastForces) {
  for (const ContactFile& recorded : recorded_contact_problems()) {
    if (recorded.delta_free.size() == 1) continue;
    SCOPED_TRACE(recorded.name);
    const GaussSeidelSettings settings{.tolerance = 1e-8, .max_sweeps = 2000};
    VectorXd f = VectorXd::Zero(3 * recorded.contacts());
    int warm_sweeps = 0;
    int cold_sweeps = 0;
    for (std::size_t step = 0; step < recorded.delta_free.size(); ++step) {
      SCOPED_TRACE(step);
      const ContactData problem = problem_of(recorded, step);
      const Solution solution = solve(problem, settings, f);
      ASSERT_EQ(solution.report.status, SolveStatus::kConverged);
      expect_laws(problem, solution, settings.tolerance);
      warm_sweeps += solution.report.sweeps;
      cold_sweeps += solve(problem, settings).report.sweeps;
      f = solution.f;
    }
    EXPECT_LT(warm_sweeps, cold_sweeps);
  }
}

TEST_P(GaussSeidel, NeedsNoSweepAtTheSolution) {
  for (const ContactFile& recorded : recorded_contact_problems()) {
    SCOPED_TRACE(recorded.name);
    const Solution solution = solve(problem_of(recorded), {.tolerance = 1e-10, .max_sweeps = 1}, recorded.f_reference);
    EXPECT_EQ(solution.report.status, SolveStatus::kConverged);
    EXPECT_EQ(solution.report.sweeps, 0);
    // Clamped into the cones, which the reference leaves by rounding.
    EXPECT_LE((solution.f - recorded.f_reference).cwiseAbs().maxCoeff(), 1e-12 * recorded.f_reference.maxCoeff());
  }
}

TEST_P(GaussSeidel, RandomProblemsObeySignoriniAndCoulomb) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const ContactData problem = random_problem(1 + seed % 25, random);
    const GaussSeidelSettings settings{.tolerance = 1e-9, .max_sweeps = 20000};
    const Solution solution = solve(problem, settings);
    ASSERT_EQ(solution.report.status, SolveStatus::kConverged);
    expect_laws(problem, solution, settings.tolerance);
    expect_gaps_of_forces(problem, solution);
  }
}

TEST_P(GaussSeidel, ForcesAreUsableWhenTheBudgetIsSpent) {
  for (const ContactFile& recorded : recorded_contact_problems()) {
    SCOPED_TRACE(recorded.name);
    const ContactData problem = problem_of(recorded);
    for (const int budget : {0, 1, 3}) {
      const Solution solution = solve(problem, {.tolerance = 0.0, .max_sweeps = budget});
      EXPECT_EQ(solution.report.status, SolveStatus::kBudgetSpent);
      EXPECT_EQ(solution.report.sweeps, budget);
      EXPECT_GT(solution.report.residual, 1e-8);
      expect_inside_cones(problem, solution.f);
      expect_gaps_of_forces(problem, solution);
    }
  }
}

TEST_P(GaussSeidel, AnyGuessIsTakenIntoTheCones) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const ContactData problem = random_problem(8, random);
    const VectorXd guess = 10.0 * random_matrix(24, 1, random);
    const Solution cut_short = solve(problem, {.tolerance = 1e-9, .max_sweeps = 0}, guess);
    expect_inside_cones(problem, cut_short.f);
    expect_gaps_of_forces(problem, cut_short);
    const Solution solution = solve(problem, {.tolerance = 1e-9, .max_sweeps = 20000}, guess);
    ASSERT_EQ(solution.report.status, SolveStatus::kConverged);
    expect_laws(problem, solution, 1e-9);
  }
}

// Without friction the problem is 0 <= W_nn f_n + delta_free_n _|_ f_n >= 0, and W_nn is definite: f_n is unique.
TEST_P(GaussSeidel, AgreesWithLemkeWithoutFriction) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const Index n = 1 + seed % 20;
    ContactData problem = random_problem(n, random);
    problem.mu.setZero();
    const Solution solution = solve(problem, {.tolerance = 1e-12, .max_sweeps = 20000});
    ASSERT_EQ(solution.report.status, SolveStatus::kConverged);

    const auto normals = Eigen::seqN(0, n, 3);
    const MatrixXd W_nn = problem.W(normals, normals);
    const VectorXd q = problem.delta_free(normals);
    LcpWorkspace work(n);
    VectorXd f_n(n);
    ASSERT_EQ(solve_lcp({W_nn, q}, 1000, work, f_n).status, LcpStatus::kSolved);
    // W_nn >= 1e-5 m/N, so a gap error of (1 + mu) e/rho, e = 1e-12 * scale, is a force error of as much over 1e-5.
    const double mean_rho = 3.0 / (problem.W.trace() / static_cast<double>(n));
    EXPECT_LE((solution.f(normals) - f_n).norm(),
              20.0 * 1e-12 * scale_N(problem) / (mean_rho * 1e-5) + 1e-12 * f_n.norm());
    EXPECT_TRUE(solution.f(Eigen::seqN(1, n, 3)).isZero(0.0));
    EXPECT_TRUE(solution.f(Eigen::seqN(2, n, 3)).isZero(0.0));
  }
}

// Turning the tangent axes of every contact changes coordinates and no physics: the same sweeps, the turned forces.
TEST_P(GaussSeidel, TangentAxesAreArbitrary) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const ContactData problem = random_problem(10, random);
    MatrixXd R = MatrixXd::Identity(30, 30);
    std::uniform_real_distribution<double> angle(0.0, 6.28);
    for (Index i = 0; i < 10; ++i) {
      R.block<2, 2>(3 * i + 1, 3 * i + 1) = Eigen::Rotation2D<double>(angle(random)).toRotationMatrix();
    }
    MatrixXd turned_W = R * problem.W * R.transpose();
    turned_W = 0.5 * (turned_W + turned_W.transpose()).eval();
    const ContactData turned{turned_W, R * problem.delta_free, problem.mu};

    const GaussSeidelSettings settings{.tolerance = 0.0, .max_sweeps = 40};
    const VectorXd f = solve(problem, settings).f;
    const VectorXd turned_f = solve(turned, settings).f;
    // Rounding only, 40 sweeps of it.
    EXPECT_LE((turned_f - R * f).cwiseAbs().maxCoeff(), 1e-12 * (1.0 + f.norm()));
  }
}

// One contact on W = diag(a, b, b), pressed by d and dragged by s: f_n = d/a, and it sticks with f_t = -s/b as long as
// that is inside the cone, else it slides with f_t = -mu f_n s/|s|.
TEST_P(GaussSeidel, OneContactByHand) {
  const double a = 2e-3;
  const double b = 1e-3;
  ContactData problem{Vector3d(a, b, b).asDiagonal().toDenseMatrix(), VectorXd(3), VectorXd::Constant(1, 0.5)};
  const GaussSeidelSettings settings{.tolerance = 1e-14, .max_sweeps = 50};
  const auto expect_force = [&](const Vector3d& delta_free, const Vector3d& expected) {
    problem.delta_free = delta_free;
    const Solution solution = solve(problem, settings);
    EXPECT_EQ(solution.report.status, SolveStatus::kConverged);
    EXPECT_LE((solution.f - expected).norm(), 1e-14);
  };
  expect_force({1e-3, 5e-4, 0.0}, Vector3d::Zero());     // open
  expect_force({0.0, 5e-4, 0.0}, Vector3d::Zero());      // touching
  expect_force({-4e-3, 0.0, 0.0}, {2.0, 0.0, 0.0});      // pressed
  expect_force({-4e-3, 3e-4, -4e-4}, {2.0, -0.3, 0.4});  // sticking
  expect_force({-4e-3, 3e-3, -4e-3}, {2.0, -0.6, 0.8});  // sliding: |f_t| = 0.5 * 2
  problem.mu[0] = 0.0;
  expect_force({-4e-3, 3e-3, -4e-3}, {2.0, 0.0, 0.0});  // without friction
}

// W's columns alone are read, so that one which was printed with few digits is solved as it is.
TEST_P(GaussSeidel, WNeedNotBeSymmetricToTheLastDigit) {
  std::mt19937 random(3);
  ContactData problem = random_problem(12, random);
  problem.W += 1e-4 * problem.W.cwiseAbs().cwiseProduct(random_matrix(36, 36, random));
  const Solution solution = solve(problem, {.tolerance = 1e-9, .max_sweeps = 20000});
  ASSERT_EQ(solution.report.status, SolveStatus::kConverged);
  expect_laws(problem, solution, 1e-9);
}

// The worst contact has at most all of the error, and at least its share of it.
TEST_P(GaussSeidel, ReportsTheWorstContact) {
  for (const ContactFile& recorded : recorded_contact_problems()) {
    const ContactData problem = problem_of(recorded);
    const SolveReport report = solve(problem, {.tolerance = 1e-6, .max_sweeps = 2000}).report;
    EXPECT_LE(report.residual_worst, report.residual);
    EXPECT_GE(report.residual_worst * std::sqrt(static_cast<double>(problem.contacts())), report.residual);
  }
}

TEST_P(GaussSeidel, WithoutContactsOrFreeMotionThereIsNothingToSolve) {
  const Solution none = solve({MatrixXd(0, 0), VectorXd(0), VectorXd(0)}, {});
  EXPECT_EQ(none.report.status, SolveStatus::kConverged);
  EXPECT_EQ(none.report.sweeps, 0);

  const ContactData still{Matrix3d::Identity(), VectorXd::Zero(3), VectorXd::Ones(1)};
  const Solution solution = solve(still, {}, VectorXd::Constant(3, 0.5));
  EXPECT_EQ(solution.report.status, SolveStatus::kConverged);
  EXPECT_TRUE(solution.f.isZero(0.0));
  EXPECT_TRUE(solution.delta.isZero(0.0));
}

TEST_P(GaussSeidel, DoesNotAllocate) {
  if (!AllocationCounter::is_available()) GTEST_SKIP() << "malloc is not ours";
  for (const Index contacts : {5, 20, 60}) {
    std::mt19937 random(1);
    const ContactData problem = random_problem(contacts, random);
    VectorXd f = VectorXd::Zero(3 * contacts);
    VectorXd delta(3 * contacts);
    const GaussSeidelSettings settings{.tolerance = 1e-6, .max_sweeps = 50};
    SweepWorkspace work(contacts);
    const AllocationCounter counter;
    const SolveReport report =
        fast() ? solve_contacts(problem, settings, work, {f, delta}) : solve_contacts(problem, settings, {f, delta});
    EXPECT_EQ(counter.count(), 0);
    EXPECT_GT(report.sweeps, 0);
  }
}

}  // namespace
}  // namespace thenar::gauss_seidel_test
