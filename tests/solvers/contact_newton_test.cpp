// SPDX-License-Identifier: Apache-2.0
#include "solvers/contact_newton.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "bench/cases/contact_families.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/recorded_problems.h"

namespace thenar::contact_newton_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

struct Solution {
  AccurateReport report;
  VectorXd f, delta, certificate;
};

Solution solve(const ContactData& problem, const AccurateSettings& settings = {}) {
  const Index n = problem.contacts();
  AccurateWorkspace work(n);
  Solution solution{{}, VectorXd::Zero(3 * n), VectorXd::Zero(3 * n), {}};
  solution.report = solve_contacts_accurately(problem, settings, work, {solution.f, solution.delta});
  solution.certificate = work.certificate;
  return solution;
}

/// The files that the plain sweeps solve, and those that break them.
std::vector<ContactFile> all_recorded_problems() {
  std::vector<ContactFile> problems = recorded_contact_problems();
  for (const auto& file : data_files("contact_hard")) problems.push_back(std::get<ContactFile>(read_problem(file)));
  return problems;
}

/// The residual as its definition says it, in long double and in terms of a projection by cases, apart from the
/// solver's: | f - P_K(f - rho_i (delta + mu |delta_t| e_n)) | over | rho_i delta_free |, rho_i = 3 / tr(W_ii).
double residual_of(const ContactData& problem, const VectorXd& f) {
  using Vector = Eigen::Matrix<long double, Eigen::Dynamic, 1>;
  const Vector delta = problem.W.cast<long double>() * f.cast<long double>() + problem.delta_free.cast<long double>();
  long double error = 0.0L, scale = 0.0L;
  for (Index i = 0; i < problem.contacts(); ++i) {
    const long double rho = 3.0L / problem.W.block<3, 3>(3 * i, 3 * i).trace(), mu = problem.mu[i];
    const Eigen::Matrix<long double, 3, 1> f_i = f.segment<3>(3 * i).cast<long double>();
    Eigen::Matrix<long double, 3, 1> x = f_i - rho * delta.segment<3>(3 * i);
    x[0] -= rho * mu * delta.segment<2>(3 * i + 1).norm();
    const long double x_t = x.tail<2>().norm();
    if (x_t > mu * x[0] || x[0] < 0.0L) {
      // Along the generator (1, mu) in the plane of x; nothing if x is in the polar cone.
      const long double along = std::max(0.0L, (x[0] + mu * x_t) / (1.0L + mu * mu));
      x.tail<2>() *= x_t > 0.0L ? mu * along / x_t : 0.0L;
      x[0] = along;
    }
    error += (f_i - x).squaredNorm();
    scale += (rho * problem.delta_free.segment<3>(3 * i).cast<long double>()).squaredNorm();
  }
  return static_cast<double>(std::sqrt(error / scale));
}

void expect_inside_cones(const ContactData& problem, const VectorXd& f) {
  ASSERT_TRUE(f.allFinite());
  for (Index i = 0; i < problem.contacts(); ++i) {
    EXPECT_GE(f[3 * i], 0.0);
    EXPECT_LE(f.segment<2>(3 * i + 1).norm(), problem.mu[i] * f[3 * i] * (1.0 + 1e-15));  // Scaled back: rounding.
  }
}

/// y >= 0 with y'W = 0 up to rounding and y.delta_free < 0 by far more: then no f has all gaps >= 0, since the sum of y
/// times the gaps would be y.delta_free.
void expect_proof(const ContactData& problem, const VectorXd& certificate) {
  VectorXd y = VectorXd::Zero(problem.delta_free.size());
  for (Index i = 0; i < problem.contacts(); ++i) y[3 * i] = certificate[i];
  EXPECT_GE(certificate.minCoeff(), 0.0);
  EXPECT_EQ(certificate.maxCoeff(), 1.0);
  // The rounding of some ten solves with a matrix of 1e-4 of W: 1e-16 * 1e4, and some.
  EXPECT_LE((problem.W.transpose() * y).norm(), 1e-11 * problem.W.norm() * y.norm());
  EXPECT_LT(y.dot(problem.delta_free), -1e-6 * y.norm() * problem.delta_free.norm());
}

TEST(AccurateContacts, SolveEveryRecordedProblem) {
  for (const ContactFile& recorded : all_recorded_problems()) {
    SCOPED_TRACE(recorded.name);
    const ContactData problem{recorded.W, recorded.delta_free[0], recorded.mu};
    // Files printed with few digits: W is not symmetric, and no law of mechanics.
    const bool symmetric = (recorded.W - recorded.W.transpose()).norm() < 1e-9 * recorded.W.norm();
    const double tolerance = symmetric ? 1e-8 : 1e-6;
    const Solution solution = solve(problem, {.tolerance = tolerance});
    EXPECT_EQ(solution.report.solve.status, SolveStatus::kConverged);
    EXPECT_LE(solution.report.solve.residual, tolerance);
    // Both round W f, whose terms may be some hundred times delta_free.
    EXPECT_NEAR(residual_of(problem, solution.f), solution.report.solve.residual, 1e-12);
    expect_inside_cones(problem, solution.f);
  }
}

// At least 99 of 100, of every family: solved to 1e-8 as told by the oracle, or proven to have no solution.
TEST(AccurateContacts, AnswerRandomProblemsOfEveryFamily) {
  constexpr int kProblems = 100;
  for (const ContactFamily& family : kContactFamilies) {
    SCOPED_TRACE(family.name);
    const FamilyRecord record = run_family(family, 0, kProblems, [](const ContactData& problem) {
      const Solution solution = solve(problem);
      expect_inside_cones(problem, solution.f);
      if (solution.report.solve.status == SolveStatus::kConverged) {
        EXPECT_LE(residual_of(problem, solution.f), 1.01e-8);
        EXPECT_TRUE(solution.certificate.isZero(0.0));
      } else if (solution.report.solve.status == SolveStatus::kNoSolution) {
        expect_proof(problem, solution.certificate);
      }
      return FamilyAnswer{solution.report.solve};
    });
    EXPECT_GE(record.solved + record.no_solution, 99 * kProblems / 100);
  }
}

// A rigid body between two rigid walls, one contact on each: it fits, or it does not.
TEST(AccurateContacts, ATightFitHasForcesOrAProof) {
  for (const double mu : {0.0, 0.5}) {
    SCOPED_TRACE(mu);
    Eigen::Matrix3Xd point(3, 2), normal(3, 2);
    point << -0.01, 0.01, 0.0, 0.0, 0.0, 0.0;
    normal << 1.0, -1.0, 0.0, 0.0, 0.0, 0.0;
    families::Vector6d push = families::Vector6d::Zero();
    push[0] = 3.0;
    const ContactData fits = families::rigid_body(point, normal, 1e-6, 0.0, mu, push);
    EXPECT_EQ(solve(fits).report.solve.status, SolveStatus::kConverged);

    const ContactData tight = families::rigid_body(point, normal, -1e-6, 0.0, mu, push);
    const Solution none = solve(tight);
    EXPECT_EQ(none.report.solve.status, SolveStatus::kNoSolution);
    expect_proof(tight, none.certificate);
    // Both walls press alike, and to fit the gaps must be opened by 2 x 1 um.
    EXPECT_NEAR(none.certificate[1], none.certificate[0], 1e-9);
    EXPECT_NEAR(none.certificate[0] * tight.delta_free[0] + none.certificate[1] * tight.delta_free[3], -2e-6, 1e-14);

    // However little compliance there is, then there are forces: 1 um into 1e-9 m/N, and half of the push.
    const ContactData soft = families::rigid_body(point, normal, -1e-6, 1e-9, mu, push);
    const Solution squeezed = solve(soft);
    EXPECT_EQ(squeezed.report.solve.status, SolveStatus::kConverged);
    EXPECT_NEAR(squeezed.f[0] + squeezed.f[3], 2000.0, 1.0);
  }
}

TEST(AccurateContacts, AContactThatNoForceOpensHasNoSolution) {
  const ContactData problem{MatrixXd::Zero(3, 3), Vector3d(-1e-4, 0.0, 0.0), VectorXd::Ones(1)};
  const Solution solution = solve(problem);
  EXPECT_EQ(solution.report.solve.status, SolveStatus::kNoSolution);
  expect_proof(problem, solution.certificate);
}

// The same beside contacts that Gauss-Seidel stalls on: the proof does not wait for their forces.
TEST(AccurateContacts, AContactThatNoForceOpensIsFoundBesideHardOnes) {
  for (const auto& file : data_files("contact_hard")) {
    const auto recorded = std::get<ContactFile>(read_problem(file));
    SCOPED_TRACE(recorded.name);
    const Index n = recorded.contacts();
    ContactData problem{MatrixXd::Zero(3 * n + 3, 3 * n + 3), VectorXd::Zero(3 * n + 3), VectorXd::Ones(n + 1)};
    problem.W.topLeftCorner(3 * n, 3 * n) = recorded.W;
    problem.delta_free.head(3 * n) = recorded.delta_free[0];
    problem.mu.head(n) = recorded.mu;
    const double size_m = recorded.delta_free[0].cwiseAbs().maxCoeff();
    problem.delta_free[3 * n] = -size_m;
    const Solution none = solve(problem, {.max_sweeps = 20});
    EXPECT_EQ(none.report.solve.status, SolveStatus::kNoSolution);
    EXPECT_EQ(none.report.steps, 0);
    EXPECT_EQ(none.certificate[n], 1.0);
    EXPECT_EQ(none.certificate.sum(), 1.0);
    expect_proof(problem, none.certificate);
    expect_inside_cones(problem, none.f);

    // What rounding may leave of a gap is touching: the contact takes no part.
    problem.delta_free[3 * n] = -1e-12 * size_m;
    EXPECT_NE(solve(problem, {.max_sweeps = 20}).report.solve.status, SolveStatus::kNoSolution);
  }
}

TEST(AccurateContacts, FewStepsStillGiveUsableForces) {
  for (const int steps : {0, 1, 5}) {
    const ContactData problem = kContactFamilies[6].make(1);
    const AccurateSettings settings{.tolerance = 0.0, .max_sweeps = 20, .max_steps = steps};
    const Solution solution = solve(problem, settings);
    EXPECT_EQ(solution.report.solve.status, SolveStatus::kBudgetSpent);
    expect_inside_cones(problem, solution.f);
    EXPECT_NEAR(residual_of(problem, solution.f), solution.report.solve.residual, 1e-12);
  }
}

TEST(AccurateContacts, AnyProblemEnds) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    SCOPED_TRACE(seed);
    const ContactData good = kContactFamilies[7].make(seed);
    std::vector<ContactData> problems(7, good);
    problems[0].mu.setConstant(1e300);
    problems[1].mu.setZero();
    problems[2].W *= 1e-200;
    problems[3].W = -good.W;
    problems[3].W.diagonal() = good.W.diagonal();
    problems[4].W(0, 5) = nan;
    problems[5].delta_free[3] = nan;
    problems[6].W.setZero();
    for (const ContactData& problem : problems) {
      const Solution solution = solve(problem, {.tolerance = 1e-8, .max_sweeps = 20, .max_steps = 50});
      EXPECT_TRUE(solution.f.allFinite() && solution.delta.allFinite() && solution.certificate.allFinite());
      EXPECT_FALSE(std::isnan(solution.report.solve.residual));
      for (Index i = 0; i < problem.contacts(); ++i) EXPECT_GE(solution.f[3 * i], 0.0);
    }
  }
  EXPECT_EQ(solve({MatrixXd(0, 0), VectorXd(0), VectorXd(0)}).report.solve.status, SolveStatus::kConverged);
}

// The workspace may be larger than the problem, and what it was used for before leaves no trace.
TEST(AccurateContacts, SameProblemSameBits) {
  const ContactData problem = kContactFamilies[6].make(3), other = kContactFamilies[7].make(4);
  AccurateWorkspace work(40);
  VectorXd f_1 = VectorXd::Zero(72), f_2 = f_1, f_other = VectorXd::Zero(96), delta(96);
  const auto run = [&](const ContactData& p, VectorXd& f) {
    return solve_contacts_accurately(p, {}, work, {f, delta.head(f.size())});
  };
  EXPECT_GT(run(problem, f_1).steps, 0);
  (void)run(other, f_other);
  (void)run(problem, f_2);
  EXPECT_EQ(f_1, f_2);
}

TEST(AccurateContacts, DoNotAllocate) {
  if (!AllocationCounter::is_available()) GTEST_SKIP() << "malloc is not ours";
  for (const ContactFamily& family : kContactFamilies) {
    for (std::uint64_t seed = 0; seed < 5; ++seed) {
      const ContactData problem = family.make(seed);
      AccurateWorkspace work(problem.contacts());
      VectorXd f = VectorXd::Zero(problem.delta_free.size()), delta(f.size());
      const AllocationCounter counter;
      (void)solve_contacts_accurately(problem, {}, work, {f, delta});
      EXPECT_EQ(counter.count(), 0) << family.name << " " << seed;
    }
  }
}

TEST(ContactFamilies, AreTheSameForTheSameSeed) {
  for (const ContactFamily& family : kContactFamilies) {
    const ContactData a = family.make(7), b = family.make(7), c = family.make(8);
    EXPECT_EQ(a.W, b.W);
    EXPECT_EQ(a.delta_free, b.delta_free);
    EXPECT_FALSE(a.delta_free.size() == c.delta_free.size() && a.delta_free == c.delta_free);
    EXPECT_EQ(a.W, a.W.transpose());
    EXPECT_GE(a.mu.minCoeff(), 0.0);
  }
}

}  // namespace
}  // namespace thenar::contact_newton_test
