// SPDX-License-Identifier: Apache-2.0
#include "engine/finder/grasp_deficit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "tests/support/algebra.h"
#include "tests/support/grasp_problems.h"

namespace thenar::grasp_deficit_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

GraspStatus status_of(const Grasp& grasp) {
  VectorXd f(3 * grasp.n());
  return solve_grasp_forces(grasp.problem(FrictionCone::kPyramid), f).status;
}

/// Of three to five contacts; every second one with a friction of each contact's own.
Grasp some_grasp(unsigned seed) {
  std::mt19937 random(seed);
  const Grasp grasp = random_grasp(3 + seed % 3, random);
  return seed % 2 == 0 ? grasp : with_random_grips(grasp, random);
}

// min 1/2 |e|^2 over G (f + e) = W, f = E z, z >= 0. Its optimum is e = G'l with E'e <= 0 and e.f = 0, and then
// |e|^2 = l.G e = l.W - e.f = e.(G^+ W).
TEST(GraspDeficit, IsExplainedByTheLeastMissingForces) {
  int infeasible = 0;
  for (unsigned seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE(seed);
    const Grasp grasp = some_grasp(seed);
    const bool feasible = status_of(grasp) == GraspStatus::kOptimal;
    infeasible += feasible ? 0 : 1;
    const GraspDeficit deficit = explain_infeasible_grasp(grasp.problem(FrictionCone::kPyramid));
    VectorXd e(3 * grasp.n());
    for (Index i = 0; i < grasp.n(); ++i) e.segment<3>(3 * i) = grasp.contacts[i].axes * deficit.missing_N.col(i);

    const MatrixXd G = grasp_map(grasp);
    const MatrixXd G_pinv = pseudo_inverse(G);
    // Forces of a few newtons through matrices of condition about 100.
    EXPECT_LE((e - G_pinv * (G * e)).norm(), 1e-10);
    EXPECT_LE((pyramid_edges(grasp).transpose() * e).maxCoeff(), 1e-9);
    EXPECT_NEAR(e.squaredNorm(), e.dot(G_pinv * grasp.wrench), 1e-9);
    Grasp rest = grasp;
    rest.wrench -= G * e;
    EXPECT_LE(wrench_out_of_reach(rest), 1e-9);
    EXPECT_EQ(e.norm() < 1e-9, feasible);
  }
  EXPECT_GT(infeasible, 20);
}

// The same with round cones: |e_t| is as much as e_n allows, mu |e_t| <= -e_n; and what is left can be had, by pyramids
// inscribed in the cones with 64 edges, up to their gap to the cone of 1 - cos(pi / 64) = 1.2e-3.
TEST(GraspDeficit, IsExplainedForRoundCones) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    SCOPED_TRACE(seed);
    const Grasp grasp = some_grasp(seed);
    const GraspDeficit deficit = explain_infeasible_grasp(grasp.problem(FrictionCone::kExact));
    VectorXd e(3 * grasp.n());
    MatrixXd rays = MatrixXd::Zero(3 * grasp.n(), 64 * grasp.n());
    for (Index i = 0; i < grasp.n(); ++i) {
      const Vector3d e_C = deficit.missing_N.col(i);
      const double mu = friction_of(grasp, i);
      EXPECT_LE(mu * e_C.tail<2>().norm() + e_C[0], 1e-6);
      e.segment<3>(3 * i) = grasp.contacts[i].axes * e_C;
      for (int k = 0; k < 64; ++k) {
        const double angle = 2.0 * std::numbers::pi * k / 64.0;
        const Vector3d ray(1.0, mu * std::cos(angle), mu * std::sin(angle));
        rays.block<3, 1>(3 * i, 64 * i + k) = grasp.contacts[i].axes * ray;
      }
    }
    const MatrixXd G = grasp_map(grasp);
    const MatrixXd G_pinv = pseudo_inverse(G);
    const VectorXd least = G_pinv * grasp.wrench;
    EXPECT_NEAR(e.squaredNorm(), e.dot(least), 1e-6);
    const double missing = distance_from_cone(G_pinv * G * rays, least);
    EXPECT_NEAR(missing, e.norm(), 2e-3 * (1.0 + least.norm()));
    EXPECT_GE(missing, e.norm() - 1e-6);
  }
}

TEST(GraspDeficit, LeastFrictionIsTheBorderOfFeasibility) {
  Grasp grasp = box_grasp(0.01);
  // The thumb at the left carries as much as the two fingers at the right: any friction holds the load by itself.
  grasp.wrench << 0.0, 0.0, 1.0, 0.0, 0.0, 0.0;
  EXPECT_NEAR(explain_infeasible_grasp(grasp.problem(FrictionCone::kPyramid)).least_friction, 0.0, 1e-3);

  for (unsigned seed = 0; seed < 30; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    Grasp other = random_grasp(3, random);
    const double least = explain_infeasible_grasp(other.problem(FrictionCone::kPyramid)).least_friction;
    if (least == 0.0) continue;
    if (std::isfinite(least)) {
      other.friction = least + 1e-6;
      EXPECT_EQ(status_of(other), GraspStatus::kOptimal);
      other.friction = least - 1e-3;
    } else {
      other.friction = 10.0;
    }
    if (other.friction >= 0.0) {
      EXPECT_EQ(status_of(other), GraspStatus::kInfeasible);
    }
  }
}

// Where contacts differ it is that of all: what they had does not count, only how they squeeze.
TEST(GraspDeficit, LeastFrictionIsTheSameWhateverEachContactHad) {
  for (unsigned seed = 0; seed < 30; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const Grasp grasp = random_grasp(3, random);
    Grasp each = with_random_grips(grasp, random);
    for (ContactGrip& grip : each.grips) grip.internal_force_N = grasp.internal_force_N;
    for (const FrictionCone cone : {FrictionCone::kPyramid, FrictionCone::kExact}) {
      EXPECT_EQ(explain_infeasible_grasp(each.problem(cone)).least_friction,
                explain_infeasible_grasp(grasp.problem(cone)).least_friction);
    }
  }
}

}  // namespace
}  // namespace thenar::grasp_deficit_test
