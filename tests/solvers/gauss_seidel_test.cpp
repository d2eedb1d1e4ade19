#include "solvers/gauss_seidel.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "solvers/lcp.h"
#include "solvers/residual.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/recorded_problems.h"

namespace thenar::gauss_seidel_test {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

double rho(const ContactData& problem, Index i) { return 3.0 / problem.W.block<3, 3>(3 * i, 3 * i).trace(); }

/// The residual's unit: residual times this is a force.
double scale_N(const ContactData& problem) {
  double sum = 0.0;
  for (Index i = 0; i < problem.contacts(); ++i) {
    sum += (rho(problem, i) * problem.delta_free.segment<3>(3 * i)).squaredNorm();
  }
  return std::sqrt(sum);
}

struct Solution {
  SolveReport report;
  VectorXd f;
  VectorXd delta;
};

/// Every property holds for the plain sweeps and for the fast ones, which work in single precision and are accelerated.
class GaussSeidel : public testing::TestWithParam<bool> {
 protected:
  [[nodiscard]] static bool fast() { return GetParam(); }

  [[nodiscard]] static Solution solve(const ContactData& problem, const GaussSeidelSettings& settings, VectorXd f) {
    VectorXd delta = VectorXd::Constant(f.size(), std::numeric_limits<double>::quiet_NaN());
    SolveReport report;
    if (fast()) {
      SweepWorkspace work(problem.contacts());
      report = solve_contacts(problem, settings, work, {f, delta});
    } else {
      report = solve_contacts(problem, settings, {f, delta});
    }
    return {report, f, delta};
  }

  [[nodiscard]] static Solution solve(const ContactData& problem, const GaussSeidelSettings& settings) {
    return solve(problem, settings, VectorXd::Zero(problem.delta_free.size()));
  }
};

INSTANTIATE_TEST_SUITE_P(Sweeps, GaussSeidel, testing::Bool(),
                         [](const auto& sweeps) { return sweeps.param ? "Fast" : "Plain"; });

MatrixXd random_matrix(Index rows, Index cols, std::mt19937& random) {
  std::normal_distribution<double> normal;
  return MatrixXd::NullaryExpr(rows, cols, [&] { return normal(random); });
}

/// Contacts that share a mechanism of nine freedoms, on a compliant surface; about half are pressed together.
ContactData random_problem(Index contacts, std::mt19937& random) {
  const MatrixXd J = random_matrix(3 * contacts, 9, random);
  ContactData problem;
  problem.W = 1e-5 * (0.1 * J * J.transpose() + MatrixXd::Identity(3 * contacts, 3 * contacts));
  problem.delta_free = 1e-5 * random_matrix(3 * contacts, 1, random);
  problem.mu = 0.5 * random_matrix(contacts, 1, random).cwiseAbs();
  return problem;
}

ContactData problem_of(const ContactFile& recorded, std::size_t step = 0) {
  return {recorded.W, recorded.delta_free[step], recorded.mu};
}

/// Signorini's and Coulomb's laws, contact by contact, on gaps computed here; shares no code with the solver.
///
/// The residual bounds e = |f - p|, p = P_K(f - rho u), u = delta + mu |delta_t| e_n, by tolerance * scale. By the
/// definition of a projection v = u + (p - f)/rho satisfies p in K, v in K* and p.v = 0 exactly, and it differs from u
/// by at most e/rho. Written out in f and delta, to first order in e, this gives the four tolerances below.
void expect_laws(const ContactData& problem, const Solution& solution, double tolerance) {
  const VectorXd& f = solution.f;
  const VectorXd delta = problem.W * f + problem.delta_free;
  const double e_N = tolerance * scale_N(problem);
  for (Index i = 0; i < problem.contacts(); ++i) {
    SCOPED_TRACE(testing::Message() << "contact " << i);
    const double mu = problem.mu[i];
    const double f_n = f[3 * i];
    const Vector2d f_t = f.segment<2>(3 * i + 1);
    const double delta_n = delta[3 * i];
    const Vector2d delta_t = delta.segment<2>(3 * i + 1);
    const double e_m = e_N / rho(problem, i);

    EXPECT_GE(f_n, 0.0);
    EXPECT_LE(f_t.norm(), mu * f_n * (1.0 + 1e-15));  // scaled back to the cone: the rounding of that
    EXPECT_GE(delta_n, -(1.0 + mu) * e_m);
    if (f_n > e_N) {
      EXPECT_LE(delta_n, (1.0 + mu) * e_m);
    }
    // Friction dissipates all it can: f_t.delta_t = -mu f_n |delta_t|.
    EXPECT_NEAR(f_t.dot(delta_t), -mu * f_n * delta_t.norm(),
                (1.0 + mu) * e_N * delta_t.norm() + 2.0 * (mu * f_n + e_N) * e_m);
  }
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
