// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "bench/cases/grasp_families.h"

namespace thenar::grasp_agreement_test {
namespace {

using Eigen::Index;
using Real = long double;  // Of the checks: their own rounding does not count.
using Real3 = Eigen::Matrix<Real, 3, 1>;

constexpr int kProblems = 10000;
// Far from the seeds that any constant of the solvers was chosen on.
constexpr std::uint64_t kFirstSeed = 500000;

// What a hand meets.
constexpr GraspFamily kBox{"box", 2, 8, grasp_families::box};
constexpr GraspFamily kSphere{"sphere", 2, 8, grasp_families::sphere};
constexpr GraspFamily kScattered{"scattered", 2, 8, grasp_families::scattered};

struct Solution {
  GraspReport report;
  Eigen::VectorXd f;
};

Solution solve(const Grasp& grasp, FrictionCone cone) {
  Eigen::VectorXd f = Eigen::VectorXd::Zero(3 * grasp.n());
  const GraspReport report = solve_grasp_forces(grasp.problem(cone), f);
  return {report, f};
}

// The optimum is unique, and two methods without a step in common find it. Lemke's method loses the digits that its
// largest entries have more than the forces: forces agree to 1e-9 of themselves up to 30 times the wrench (torques by
// arms of 3 cm), and beyond that, at the border of feasibility, to 1e-6.
TEST(GraspAgreement, ActiveSetAndLemkesMethodWithThreeContacts) {
  GraspWorkspace work;
  int optimal = 0;
  int near_border = 0;
  for (std::uint64_t seed = kFirstSeed; seed < kFirstSeed + kProblems; ++seed) {
    SCOPED_TRACE(seed);
    const Grasp grasp = (seed % 3 == 0 ? kBox : seed % 3 == 1 ? kSphere : kScattered).problem(seed, 3);
    const Solution solution = solve(grasp, FrictionCone::kPyramid);
    Eigen::VectorXd f(3 * grasp.n());
    const GraspReport by_lemke = solve_grasp_forces_by_lemke(grasp.problem(FrictionCone::kPyramid), work, f);
    ASSERT_NE(solution.report.status, GraspStatus::kBudgetSpent);
    ASSERT_EQ(by_lemke.status, solution.report.status);
    if (by_lemke.status != GraspStatus::kOptimal) continue;
    ++optimal;
    const double size_N = solution.f.norm();
    const double wrench_N =
        grasp.wrench.head<3>().norm() + grasp.wrench.tail<3>().norm() / 0.03 + grasp.internal_force_N;
    const bool is_near_border = size_N > 30.0 * wrench_N;
    near_border += is_near_border ? 1 : 0;
    EXPECT_LE((f - solution.f).norm(), (is_near_border ? 1e-6 : 1e-9) * size_N);
  }
  // Of the three families about all, all, and a quarter can be held.
  EXPECT_GT(optimal, kProblems / 2);
  EXPECT_LT(near_border, kProblems / 50);
}

/// How fast a force of the cone, with a normal part of 1, can at most move along v (contact axes).
Real support(FrictionCone cone, Real mu, const Real3& v) {
  const Real tangential = cone == FrictionCone::kPyramid ? std::abs(v[1]) + std::abs(v[2]) : std::hypot(v[1], v[2]);
  return v[0] + mu * tangential;
}

/// The least that any forces inside the cones have to be, by the twist l, over what they have to be anyway:
/// W.l = sum f_i.v_i <= sum f_n,i support_i <= |f| |(support)_+|, and |f| >= |F| / sqrt(n) for the wrench's force F.
Real least_forces(const Grasp& grasp, FrictionCone cone, const Vector6d& twist) {
  const Real3 shift = twist.head<3>().cast<Real>();
  const Real3 turn = twist.tail<3>().cast<Real>();
  Real squares = 0.0L;
  Real rounding = 0.0L;  // Of the twist, which is in doubles.
  for (const GraspContact& contact : grasp.contacts) {
    const Real3 arm = (contact.point_m - grasp.centre_m).cast<Real>();
    const Real3 v = contact.axes.cast<Real>().transpose() * (shift + turn.cross(arm));
    const Real along = std::max(0.0L, support(cone, grasp.friction, v));
    squares += along * along;
    rounding += 1e-15L * (shift.norm() + turn.norm() * arm.norm());
  }
  const Real work = twist.cast<Real>().dot(grasp.wrench.cast<Real>());
  const Real anyway = Real(grasp.wrench.head<3>().norm()) / std::sqrt(Real(grasp.n()));
  return work / (std::max(0.0L, std::sqrt(squares) - rounding) + 1e-300L) / anyway;
}

/// Whether forces are inside the cones and give the wrench, to 1e-9 of their size: the solver's promise. Torques count
/// by the contacts' distances.
void expect_held(const Grasp& grasp, FrictionCone cone, const Eigen::VectorXd& f) {
  Eigen::Matrix<Real, 6, 1> missing = grasp.wrench.cast<Real>();
  Real reach_m = 0.0L;
  Real outside = 0.0L;
  for (Index i = 0; i < grasp.n(); ++i) {
    const Real3 f_i = f.segment<3>(3 * i).cast<Real>();
    const Real3 arm = (grasp.contacts[i].point_m - grasp.centre_m).cast<Real>();
    missing.head<3>() -= f_i;
    missing.tail<3>() -= arm.cross(f_i);
    reach_m = std::max(reach_m, arm.norm());
    const Real3 f_C = grasp.contacts[i].axes.cast<Real>().transpose() * f_i;
    const Real tangential = cone == FrictionCone::kPyramid ? f_C.tail<2>().cwiseAbs().maxCoeff() : f_C.tail<2>().norm();
    outside = std::max({outside, tangential - Real(grasp.friction) * f_C[0], -f_C[0]});
  }
  const Real size = f.cast<Real>().norm();
  EXPECT_LE(missing.head<3>().norm(), 1e-8L * size);
  EXPECT_LE(missing.tail<3>().norm(), 1e-8L * size * reach_m);
  EXPECT_LE(outside, 1e-8L * size);
}

class GraspVerdict : public testing::TestWithParam<FrictionCone> {};

// Either forces that hold the object or a twist that proves that there are none: from points and frames alone.
TEST_P(GraspVerdict, IsRight) {
  const FrictionCone cone = GetParam();
  int infeasible = 0;
  for (std::uint64_t seed = kFirstSeed; seed < kFirstSeed + kProblems; ++seed) {
    SCOPED_TRACE(seed);
    const Grasp grasp = (seed % 3 == 0 ? kBox : seed % 3 == 1 ? kSphere : kScattered).problem(seed);
    const Solution solution = solve(grasp, cone);
    ASSERT_NE(solution.report.status, GraspStatus::kBudgetSpent);
    if (solution.report.status == GraspStatus::kOptimal) {
      expect_held(grasp, cone, solution.f);
    } else {
      ++infeasible;
      // Forces count as none at 1e8 times those without cones; those are at least what `least_forces` divides by, and a
      // force with a normal part of 1 is at most sqrt(1 + 2 mu^2) < 2 long.
      EXPECT_GE(least_forces(grasp, cone, solution.report.multiplier), 0.5e8L);
    }
  }
  EXPECT_GT(infeasible, kProblems / 10);
  EXPECT_LT(infeasible, kProblems / 2);
}

INSTANTIATE_TEST_SUITE_P(Cones, GraspVerdict, testing::Values(FrictionCone::kPyramid, FrictionCone::kExact),
                         [](const auto& cone) { return cone.param == FrictionCone::kPyramid ? "Pyramid" : "Exact"; });

}  // namespace
}  // namespace thenar::grasp_agreement_test
