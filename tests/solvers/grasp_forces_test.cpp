// SPDX-License-Identifier: Apache-2.0
#include "solvers/grasp_forces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <tuple>

#include "tests/solvers/grasp_answers.h"
#include "tests/support/algebra.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/grasp_problems.h"

namespace thenar::grasp_forces_test {
namespace {

using namespace grasp_answers;

Grasp hand_grasp(const nlohmann::json& hand) {
  Grasp grasp;
  for (int i = 0; i < 3; ++i) {
    grasp.contacts.push_back({vector_of(hand.at("contact_points")[i]), matrix_of(hand.at("B")[i])});
  }
  grasp.centre_m = vector_of(hand.at("object_centre"));
  return grasp;
}

TEST(GraspForces, AgreeWithTheRecordedOptima) {
  for (const auto& problem : recorded_small_problems("P1")) {
    SCOPED_TRACE(problem.at("file"));
    const Grasp grasp = recorded_grasp(problem);
    EXPECT_LE((grasp_map(grasp) - matrix_of(problem.at("G"))).cwiseAbs().maxCoeff(), 1e-15);
    const Solution solution = solve(grasp);
    if (problem.at("status") == "infeasible") {
      EXPECT_EQ(solution.report.status, GraspStatus::kInfeasible);
      EXPECT_TRUE(solution.f.hasNaN()) << "f must be left as it was";
      continue;
    }
    ASSERT_EQ(solution.report.status, GraspStatus::kOptimal);
    // 1e-10 of the forces (up to 30 N), but for the contacts that stray 6e-7 of their distance from a line: there
    // rounding of the points (1e-16) is amplified by (1/6e-7) in the forces, and by a few more in the pivots.
    const double tolerance_N = problem.at("class") == "nearcollinear" ? 1e-6 : 1e-9;
    EXPECT_LE((solution.f - vector_of(problem.at("f_opt"))).cwiseAbs().maxCoeff(), tolerance_N);
  }
}

TEST(GraspForces, AgreeWithTheHandsReference) {
  const nlohmann::json hand = read_json(THENAR_TEST_DATA "/hand_reference.json");
  Grasp grasp = hand_grasp(hand);
  // The same products of the same numbers, to the last bit or two.
  EXPECT_LE((grasp_map(grasp) - matrix_of(hand.at("G"))).cwiseAbs().maxCoeff(), 1e-16);
  for (const auto& problem : hand.at("grasp")) {
    grasp.wrench = vector_of(problem.at("W"));
    grasp.friction = problem.at("mu");
    grasp.internal_force_N = problem.at("lam");
    const Solution solution = solve(grasp);
    if (problem.at("f").is_null()) {
      EXPECT_EQ(solution.report.status, GraspStatus::kInfeasible);
      continue;
    }
    ASSERT_EQ(solution.report.status, GraspStatus::kOptimal);
    // Forces of a few newtons, a dozen pivots: see expect_optimal.
    EXPECT_LE((solution.f - vector_of(problem.at("f"))).cwiseAbs().maxCoeff(), 1e-10);
  }
}

// Every status is proved: an optimum by its multipliers, infeasibility by the distance of the wrench from the cone of
// wrenches that the pyramids can give.
TEST(GraspForces, EveryAnswerIsProved) {
  int infeasible = 0;
  for (unsigned seed = 0; seed < 500; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const Grasp grasp = random_grasp(3 + seed % 6, random);
    const Solution solution = solve(grasp);
    const double out_of_reach_N = wrench_out_of_reach(grasp);
    ASSERT_NE(solution.report.status, GraspStatus::kBudgetSpent);
    expect_proved(grasp, solution);
    if (solution.report.status == GraspStatus::kOptimal) {
      EXPECT_LE(out_of_reach_N, 1e-9);
    } else {
      ++infeasible;
      EXPECT_GE(out_of_reach_N, 1e-9);
    }
  }
  EXPECT_GT(infeasible, 50);
  EXPECT_LT(infeasible, 450);
}

TEST(GraspForces, EveryAnswerIsProvedOnDegenerateGrasps) {
  for (unsigned seed = 0; seed < 900; ++seed) {
    SCOPED_TRACE(seed);
    const Grasp grasp = degenerate_grasp(seed, std::array{1.0, 0.5, 0.1}[seed % 3]);
    const Solution solution = solve(grasp);
    ASSERT_NE(solution.report.status, GraspStatus::kBudgetSpent);
    EXPECT_EQ(solution.report.status == GraspStatus::kOptimal, wrench_out_of_reach(grasp) < 1e-9);
    expect_proved(grasp, solution);
  }
}

// Faces of a thin pyramid nearly coincide: multipliers grow like 1/mu^2 and the digits go, with Lemke's method at once,
// with the active set on a few problems at 1e-6. No answer is then an answer, a wrong one is not.
TEST(GraspForces, LittleFriction) {
  int optimal = 0;
  int unanswered = 0;
  int unanswered_by_lemke = 0;
  for (unsigned seed = 0; seed < 900; ++seed) {
    SCOPED_TRACE(seed);
    const Grasp grasp = degenerate_grasp(seed, std::array{0.03, 1e-3, 1e-6}[seed % 3]);
    const Solution solution = solve(grasp);
    const Solution by_lemke = solve_by_lemke(grasp);
    if (by_lemke.report.status == GraspStatus::kBudgetSpent) ++unanswered_by_lemke;
    if (solution.report.status == GraspStatus::kBudgetSpent) {
      ++unanswered;
      continue;
    }
    expect_proved(grasp, solution, std::max(1e-9, 1e-13 / grasp.friction));
    optimal += solution.report.status == GraspStatus::kOptimal ? 1 : 0;
    if (by_lemke.report.status != GraspStatus::kBudgetSpent) {
      EXPECT_EQ(by_lemke.report.status, solution.report.status);
    }
  }
  EXPECT_GT(optimal, 100);
  EXPECT_LT(unanswered_by_lemke, optimal);
  // Of 300 at a friction of 1e-6; which of them, rounding decides.
  EXPECT_LT(unanswered, 25);
}

// Two methods that have no step in common. Lemke's method loses digits where forces are large, near the border of
// feasibility: 1e-9 of the forces while they are below 100 N, for wrenches of a few. Beyond 10 kN the border is so near
// that forces follow the rounding of the contacts themselves.
TEST(GraspForces, LemkesMethodAgreesWithTheActiveSet) {
  int infeasible = 0;
  for (unsigned seed = 0; seed < 10000; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const Grasp grasp = random_grasp(2 + seed % 7, random);
    const Solution solution = solve(grasp);
    const Solution by_lemke = solve_by_lemke(grasp);
    ASSERT_NE(solution.report.status, GraspStatus::kBudgetSpent);
    ASSERT_EQ(by_lemke.report.status, solution.report.status);
    if (solution.report.status == GraspStatus::kOptimal) {
      const double size_N = solution.f.norm();
      EXPECT_LE((by_lemke.f - solution.f).norm(), (size_N < 100.0 ? 1e-9 : std::max(1e-6, 1e-10 * size_N)) * size_N);
    } else {
      ++infeasible;
      expect_infeasible(grasp, by_lemke, 1e-9);
    }
  }
  EXPECT_GT(infeasible, 1000);
  EXPECT_LT(infeasible, 9000);
}

TEST(GraspForces, FeasibleGraspsAreFoundSo) {
  for (unsigned seed = 0; seed < 2000; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    Grasp grasp = random_grasp(2 + seed % 7, random);
    grasp.friction = std::array{0.5, 1e-2, 1e-6, 0.0}[seed % 4];
    grasp = held(grasp, forces_inside(grasp, 0.9, random));
    const Solution solution = solve(grasp);
    ASSERT_EQ(solution.report.status, GraspStatus::kOptimal);
    // Errors of 1e-13 on the faces are as much more along them as the pyramid is thin.
    expect_optimal(grasp, solution, grasp.friction > 0.0 ? std::max(1e-9, 1e-13 / grasp.friction) : 1e-9);
  }
}

// Without squeeze a wrench that forces on edges of the pyramids give has an optimum on many rows at once, often at the
// tip of a pyramid.
TEST(GraspForces, OptimaOnEdgesAndTips) {
  for (unsigned seed = 0; seed < 1000; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    Grasp grasp = random_grasp(3 + seed % 6, random);
    grasp.internal_force_N = 0.0;
    VectorXd f = VectorXd::Zero(3 * grasp.n());
    for (Index i = 0; i < 1 + seed % 3; ++i)
      f += static_cast<double>(i + 1) * pyramid_edges(grasp).middleCols<4>(4 * i).col(seed % 4);
    grasp = held(grasp, f);
    const Solution solution = solve(grasp);
    ASSERT_EQ(solution.report.status, GraspStatus::kOptimal);
    expect_optimal(grasp, solution, 1e-9);
  }
}

TEST(GraspForces, TheSameProblemGivesTheSameBits) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const Grasp grasp = random_grasp(2 + seed % 7, random);
    const Solution first = solve(grasp);
    std::ignore = solve(random_grasp(8, random));
    const Solution second = solve(grasp);
    EXPECT_EQ(first.report.multiplier, second.report.multiplier);
    EXPECT_EQ(first.report.residual, second.report.residual);
    if (first.report.status == GraspStatus::kOptimal) {
      EXPECT_EQ(first.f, second.f);
    }
  }
}

// The check sees what is wrong: forces that give another wrench, and forces that give this one but are not the best.
TEST(GraspForces, TheKktErrorIsThatOfTheForces) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    Grasp grasp = random_grasp(3, random);
    grasp = held(grasp, forces_inside(grasp, 0.9, random));
    const Solution solution = solve(grasp);
    ASSERT_EQ(solution.report.status, GraspStatus::kOptimal);
    const GraspProblem problem = grasp.problem(FrictionCone::kPyramid);
    const auto error = [&](const VectorXd& f) { return grasp_kkt_error(problem, solution.report.multiplier, f); };
    const double size_N = std::max(solution.f.norm(), bias_of(grasp).norm());
    VectorXd off = solution.f;
    off[seed % 9] += 1e-3 * size_N;
    // The change is what differs from the projection; what it adds to |f| is 1e-3.
    EXPECT_NEAR(error(off), 1e-3, 2e-6);
    // Two contacts pressed together along the line through them: the wrench stays.
    VectorXd pressed = solution.f;
    const Vector3d along = (grasp.contacts[1].point_m - grasp.contacts[0].point_m).normalized();
    pressed.segment<3>(0) += 1e-3 * size_N * along;
    pressed.segment<3>(3) -= 1e-3 * size_N * along;
    EXPECT_NEAR(error(pressed), 1e-3 * std::sqrt(2.0), 4e-6);
    EXPECT_TRUE(std::isinf(infeasibility_gap(problem, -problem.wrench)));
    EXPECT_GT(infeasibility_gap(problem, problem.wrench), 1e-3);
  }
}

// f minimises 1/2 f'f - lambda N(f), N the sum of normal forces, over a set that lambda does not change. Adding the two
// statements of optimality for two lambdas gives (lambda_2 - lambda_1) (N_2 - N_1) >= 0.
TEST(GraspForces, MoreSqueezeMeansMoreNormalForce) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    Grasp grasp = random_grasp(4, random);
    double last_N = 0.0;
    for (const double squeeze_N : {0.0, 0.5, 1.0, 2.0, 5.0}) {
      grasp.internal_force_N = squeeze_N;
      const Solution solution = solve(grasp);
      if (solution.report.status != GraspStatus::kOptimal) break;
      double normal_N = 0.0;
      for (Index i = 0; i < grasp.n(); ++i) normal_N += solution.f.segment<3>(3 * i).dot(grasp.contacts[i].axes.col(0));
      EXPECT_GE(normal_N, last_N - 1e-9 * (1.0 + normal_N));
      last_N = normal_N;
    }
  }
}

TEST(GraspForces, WithoutFrictionAWrenchOffTheNormalsIsInfeasible) {
  for (unsigned seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE(seed);
    const Grasp grasp = degenerate_grasp(seed, 0.0);
    const Solution solution = solve(grasp);
    expect_proved(grasp, solution);
    EXPECT_EQ(solution.report.status == GraspStatus::kOptimal, wrench_out_of_reach(grasp) < 1e-9);
    const Solution by_lemke = solve_by_lemke(grasp);
    EXPECT_EQ(by_lemke.report.status, solution.report.status);
    std::mt19937 random(seed);
    Grasp off = grasp;
    off.wrench += 1e-3 * Vector6d::NullaryExpr([&] { return std::normal_distribution<double>()(random); });
    if (wrench_out_of_reach(off) < 1e-9) continue;
    const Solution infeasible = solve(off);
    ASSERT_EQ(infeasible.report.status, GraspStatus::kInfeasible);
    expect_infeasible(off, infeasible);
  }
}

TEST(GraspForces, WithoutFrictionALateralLoadIsInfeasible) {
  Grasp grasp = box_grasp(0.0);
  EXPECT_EQ(solve(grasp).report.status, GraspStatus::kOptimal);
  grasp.wrench[2] = 1.0;
  EXPECT_EQ(solve(grasp).report.status, GraspStatus::kInfeasible);
  grasp.friction = 0.3;
  const Solution solution = solve(grasp);
  ASSERT_EQ(solution.report.status, GraspStatus::kOptimal);
  expect_optimal(grasp, solution);
}

// Two fingers face each other and hold a lateral load F: each carries F/2, which needs a normal force of F/(2 mu).
TEST(GraspForces, OfTwoFingersByHand) {
  Grasp grasp;
  Matrix3d against;
  against << -Vector3d::UnitX(), Vector3d::UnitY(), -Vector3d::UnitZ();
  grasp.contacts = {{{-0.02, 0.0, 0.0}, Matrix3d::Identity()}, {{0.02, 0.0, 0.0}, against}};
  grasp.friction = 0.4;
  grasp.wrench[1] = 2.0;
  const Solution solution = solve(grasp);
  ASSERT_EQ(solution.report.status, GraspStatus::kOptimal);
  const VectorXd expected = (VectorXd(6) << 2.5, 1.0, 0.0, -2.5, 1.0, 0.0).finished();
  EXPECT_LE((solution.f - expected).cwiseAbs().maxCoeff(), 1e-14);

  // With a squeeze of lambda > F/(2 mu) the normal forces are lambda.
  grasp.internal_force_N = 4.0;
  EXPECT_NEAR(solve(grasp).f[0], 4.0, 1e-14);
}

TEST(GraspForces, SmallGraspsAndBadInput) {
  Grasp grasp;
  grasp.friction = 0.5;
  EXPECT_EQ(solve(grasp).report.status, GraspStatus::kOptimal);
  grasp.wrench[0] = 1.0;
  EXPECT_EQ(solve(grasp).report.status, GraspStatus::kInfeasible);
  grasp.contacts = {{Vector3d::Zero(), Matrix3d::Identity()}};
  const Solution push = solve(grasp);
  ASSERT_EQ(push.report.status, GraspStatus::kOptimal);
  EXPECT_LE((push.f - Vector3d::UnitX()).cwiseAbs().maxCoeff(), 1e-15);
  grasp.wrench[0] = -1.0;
  EXPECT_EQ(solve(grasp).report.status, GraspStatus::kInfeasible);

  // Torques about a far point round by more than the contacts' own torques are.
  grasp.centre_m = {0.3, -1.7, 2.9};
  grasp.wrench = grasp_map(grasp) * Vector3d(2.0, 0.7, -0.3);
  EXPECT_EQ(solve(grasp).report.status, GraspStatus::kOptimal);

  Grasp bad = box_grasp(0.5);
  bad.wrench[4] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(solve(bad).report.status, GraspStatus::kBudgetSpent);
  bad = box_grasp(0.5);
  bad.contacts[1].point_m[0] = std::numeric_limits<double>::infinity();
  EXPECT_EQ(solve(bad).report.status, GraspStatus::kBudgetSpent);
}

TEST(GraspForces, DoNotAllocate) {
  if (!AllocationCounter::is_available()) GTEST_SKIP() << "malloc is not ours";
  GraspWorkspace work;
  for (const Index n : {2, 3, 8}) {
    std::mt19937 random(3);
    const Grasp grasp = random_grasp(n, random);
    const GraspProblem problem = grasp.problem(FrictionCone::kPyramid);
    VectorXd f(3 * n);
    const AllocationCounter counter;
    const GraspReport report = solve_grasp_forces(problem, f);
    const GraspReport by_lemke = solve_grasp_forces_by_lemke(problem, work, f);
    EXPECT_EQ(counter.count(), 0);
    EXPECT_NE(report.status, GraspStatus::kBudgetSpent);
    EXPECT_EQ(by_lemke.status, report.status);
  }
}

}  // namespace
}  // namespace thenar::grasp_forces_test
