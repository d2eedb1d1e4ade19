// SPDX-License-Identifier: Apache-2.0
// Grasp forces where each contact has a friction and a squeeze of its own.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

#include "bench/cases/grasp_families.h"
#include "tests/solvers/grasp_answers.h"
#include "tests/support/algebra.h"
#include "tests/support/grasp_problems.h"

namespace thenar::contact_grips_test {
namespace {

using namespace grasp_answers;

/// A cone and a method for it.
struct Method {
  const char* name;
  FrictionCone cone;
  bool lemke;
};

constexpr Method kMethods[] = {{"ActiveSet", FrictionCone::kPyramid, false},
                               {"Lemke", FrictionCone::kPyramid, true},
                               {"ExactCone", FrictionCone::kExact, false}};

Solution solve(const Grasp& grasp, const Method& method) {
  GraspWorkspace work;
  VectorXd f = VectorXd::Constant(3 * grasp.n(), std::numeric_limits<double>::quiet_NaN());
  const GraspProblem problem = grasp.problem(method.cone);
  const GraspReport report =
      method.lemke ? solve_grasp_forces_by_lemke(problem, work, f) : solve_grasp_forces(problem, f);
  return {report, f};
}

/// The force of a round cone nearest to y, world axes: inside, behind the tip, or on the surface.
Vector3d nearest_in_round_cone(double mu, const Vector3d& n, const Vector3d& y) {
  const double normal = n.dot(y);
  const Vector3d tangential = y - normal * n;
  const double t = tangential.norm();
  if (t <= mu * normal) return y;
  if (normal + mu * t <= 0.0) return Vector3d::Zero();
  const double f_n = (normal + mu * t) / (1.0 + mu * mu);
  return t > 0.0 ? Vector3d(f_n * n + mu * f_n / t * tangential) : Vector3d(f_n * n);
}

/// P_K of forces of all contacts, each by its own friction.
VectorXd nearest_inside(const Grasp& grasp, FrictionCone cone, const VectorXd& forces) {
  VectorXd nearest(forces.size());
  for (Index i = 0; i < grasp.n(); ++i) {
    const Matrix3d& frame = grasp.contacts[i].axes;
    const double mu = grasp.grips[i].friction;
    const Vector3d y = forces.segment<3>(3 * i);
    nearest.segment<3>(3 * i) = cone == FrictionCone::kExact
                                    ? nearest_in_round_cone(mu, frame.col(0), y)
                                    : Vector3d(frame * nearest_in_pyramid(mu, frame.transpose() * y));
  }
  return nearest;
}

/// What f lacks of the optimum, as a share of the forces at hand: f = P_K(G'l - c) and G f = W, the wrench that is
/// missing as the least forces that would give it. World axes, plain G.
double kkt_error(const Grasp& grasp, FrictionCone cone, const Solution& solution) {
  const MatrixXd G = grasp_map(grasp);
  const VectorXd c = bias_of(grasp);
  const VectorXd off = solution.f - nearest_inside(grasp, cone, G.transpose() * solution.report.multiplier - c);
  const VectorXd missing = pseudo_inverse(G) * (G * solution.f - grasp.wrench);
  return std::max(off.norm(), missing.norm()) / std::max(solution.f.norm(), c.norm());
}

/// The least forces without cones over those that a solution needs at least, by the twist l: W.l = f.(G'l) <=
/// |f| |P_K(G'l)| for forces f inside the cones.
double gap_left(const Grasp& grasp, FrictionCone cone, const Vector6d& twist) {
  const MatrixXd G = grasp_map(grasp);
  const double least_N = (pseudo_inverse(G) * grasp.wrench).norm();
  return least_N * nearest_inside(grasp, cone, G.transpose() * twist).norm() / grasp.wrench.dot(twist);
}

class ContactGrips : public testing::TestWithParam<Method> {};

INSTANTIATE_TEST_SUITE_P(Methods, ContactGrips, testing::ValuesIn(kMethods),
                         [](const auto& method) { return method.param.name; });

// A list of equal numbers is the problem with one number: no step may tell them apart.
TEST_P(ContactGrips, EqualOnesGiveTheBitsOfOneForAll) {
  const Method& method = GetParam();
  for (const GraspFamily& family : kGraspFamilies) {
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
      SCOPED_TRACE(testing::Message() << family.name << " " << seed);
      const Grasp grasp = family.problem(seed);
      Grasp listed = grasp;
      listed.grips.assign(grasp.contacts.size(), {grasp.friction, grasp.internal_force_N});
      listed.friction = listed.internal_force_N = std::numeric_limits<double>::quiet_NaN();  // Not to be used.
      const Solution one = solve(grasp, method), each = solve(listed, method);
      ASSERT_EQ(each.report.status, one.report.status);
      EXPECT_EQ(each.report.iterations, one.report.iterations);
      EXPECT_EQ(each.report.residual, one.report.residual);
      EXPECT_EQ(each.report.multiplier, one.report.multiplier);
      const GraspProblem problem = grasp.problem(method.cone), list = listed.problem(method.cone);
      const Vector6d& l = one.report.multiplier;
      EXPECT_EQ(infeasibility_gap(list, l), infeasibility_gap(problem, l));
      if (one.report.status != GraspStatus::kOptimal) continue;
      EXPECT_EQ(each.f, one.f);
      EXPECT_EQ(grasp_kkt_error(list, l, each.f), grasp_kkt_error(problem, l, one.f));
    }
  }
}

// Convex: a multiplier proves an optimum, a twist that there is none. The solver promises a residual of 1e-9 and 1e-11
// of what the multiplier pulls; it proves that there are no forces below 1e8 times those without cones, and 1e-9 is
// what the rounding of a dozen changes may leave of velocities.
TEST_P(ContactGrips, EveryAnswerIsProved) {
  const Method& method = GetParam();
  int optimal = 0;
  int infeasible = 0;
  for (unsigned seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const Grasp grasp = with_random_grips(random_grasp(3 + seed % 6, random), random);
    const Solution solution = solve(grasp, method);
    const GraspProblem problem = grasp.problem(method.cone);
    const Vector6d& l = solution.report.multiplier;
    ASSERT_NE(solution.report.status, GraspStatus::kBudgetSpent);
    if (solution.report.status == GraspStatus::kOptimal) {
      ++optimal;
      const double size_N = std::max(solution.f.norm(), bias_of(grasp).norm());
      const double rounding = 1e-11 * (grasp_map(grasp).transpose() * l).norm() / size_N;
      EXPECT_LE(kkt_error(grasp, method.cone, solution), 1e-9 + rounding);
      EXPECT_LE(grasp_kkt_error(problem, l, solution.f), 1e-9 + rounding);
    } else {
      ++infeasible;
      EXPECT_GT(grasp.wrench.dot(l), 0.0);
      EXPECT_LE(solution.report.residual, 1e-8);
      EXPECT_LE(gap_left(grasp, method.cone, l), 1e-8 + 1e-9);
      EXPECT_LE(infeasibility_gap(problem, l), 1e-8 + 1e-9);
      EXPECT_TRUE(solution.f.hasNaN()) << "f must be left as it was";
    }
  }
  EXPECT_GT(optimal, 50);
  EXPECT_GT(infeasible, 30);
}

// Two methods without a step in common; the tolerances of the same test with one friction for all.
TEST(ContactGripsOfPyramids, LemkesMethodAgreesWithTheActiveSet) {
  for (unsigned seed = 0; seed < 3000; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const Grasp grasp = with_random_grips(random_grasp(2 + seed % 7, random), random);
    const Solution solution = grasp_answers::solve(grasp), by_lemke = solve_by_lemke(grasp);
    ASSERT_NE(solution.report.status, GraspStatus::kBudgetSpent);
    ASSERT_EQ(by_lemke.report.status, solution.report.status);
    expect_proved(grasp, solution, 1e-9);
    if (solution.report.status != GraspStatus::kOptimal) continue;
    const double size_N = solution.f.norm();
    EXPECT_LE((by_lemke.f - solution.f).norm(), (size_N < 100.0 ? 1e-9 : std::max(1e-6, 1e-10 * size_N)) * size_N);
  }
}

// A finger without friction pushes along its normal alone, whatever the others do. Laws are kept to 1e-9 of the forces.
TEST_P(ContactGrips, OfNoFrictionCarryNoTangentialForce) {
  int others_use_friction = 0;
  for (unsigned seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    Grasp grasp = with_random_grips(random_grasp(3 + seed % 6, random), random);
    const Index smooth = seed % grasp.n();
    grasp.grips[smooth].friction = 0.0;
    // What forces in the round cones give can be had.
    grasp = held(grasp, forces_inside(grasp, 0.7, random));
    const Solution solution = solve(grasp, GetParam());
    ASSERT_EQ(solution.report.status, GraspStatus::kOptimal);
    const Vector3d f_C = grasp.contacts[smooth].axes.transpose() * solution.f.segment<3>(3 * smooth);
    EXPECT_LE(f_C.tail<2>().norm(), 1e-9 * solution.f.norm());
    EXPECT_GE(f_C[0], -1e-9 * solution.f.norm());
    double others_N = 0.0;
    for (Index i = 0; i < grasp.n(); ++i) {
      if (i == smooth) continue;
      others_N += (grasp.contacts[i].axes.transpose() * solution.f.segment<3>(3 * i)).tail<2>().norm();
    }
    others_use_friction += others_N > 1e-3 * solution.f.norm() ? 1 : 0;
  }
  EXPECT_GT(others_use_friction, 250);
}

// Two fingers face each other, 2 cm to either side, and both press with N. A load F and a moment M ask for
// F/2 -+ M/4 cm across the line, and N is what the finger that comes nearest to slipping needs.
TEST_P(ContactGrips, OfTwoFingersByHand) {
  Grasp grasp;
  Matrix3d against;
  against << -Vector3d::UnitX(), Vector3d::UnitY(), -Vector3d::UnitZ();
  grasp.contacts = {{{-0.02, 0.0, 0.0}, Matrix3d::Identity()}, {{0.02, 0.0, 0.0}, against}};
  grasp.grips = {{.friction = 0.4, .internal_force_N = 0.0}, {.friction = 0.8, .internal_force_N = 0.0}};
  // A dozen operations on numbers of order 1.
  constexpr double kRounding = 1e-13;
  const auto expect_forces = [&](double N, double t_1, double t_2) {
    const Solution solution = solve(grasp, GetParam());
    ASSERT_EQ(solution.report.status, GraspStatus::kOptimal);
    const VectorXd expected = (VectorXd(6) << N, t_1, 0.0, -N, t_2, 0.0).finished();
    EXPECT_LE((solution.f - expected).cwiseAbs().maxCoeff(), kRounding) << solution.f.transpose();
  };
  grasp.wrench[1] = 2.0;
  expect_forces(1.0 / 0.4, 1.0, 1.0);
  grasp.wrench[5] = 0.02 * 1.0;
  expect_forces(1.5 / 0.8, 0.5, 1.5);
  // 1/2 (N^2 + N^2) - 6 N - 2 N is least at the mean of both lambdas.
  grasp.grips[0].internal_force_N = 6.0;
  grasp.grips[1].internal_force_N = 2.0;
  expect_forces(4.0, 0.5, 1.5);
}

// No number may pass for a good one, at whichever contact it is bad.
TEST_P(ContactGrips, NotFiniteOnesHaveNoAnswer) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    for (unsigned seed = 0; seed < 100; ++seed) {
      SCOPED_TRACE(seed);
      std::mt19937 random(seed);
      Grasp grasp = with_random_grips(random_grasp(2 + seed % 7, random), random);
      const Grasp good = grasp;
      grasp.grips[seed % grasp.n()].friction = bad;
      EXPECT_EQ(solve(grasp, GetParam()).report.status, GraspStatus::kBudgetSpent);
      grasp = good;
      grasp.grips[seed % grasp.n()].internal_force_N = bad;
      EXPECT_EQ(solve(grasp, GetParam()).report.status, GraspStatus::kBudgetSpent);
    }
  }
}

}  // namespace
}  // namespace thenar::contact_grips_test
