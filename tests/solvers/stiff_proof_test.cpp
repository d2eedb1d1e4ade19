// SPDX-License-Identifier: Apache-2.0
#include "solvers/muscles/stiff_proof.h"

#include <gtest/gtest.h>

#include "tests/solvers/stiff_laws.h"

namespace thenar::stiff_proof_test {
namespace {

using namespace stiff_laws;

// ---- Derivatives --------------------------------------------------------------------------------------------------

TEST(StiffProof, StiffnessIsThatOfTheLaw) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE(seed);
    const StiffMuscleData p = drawn(seed, seed % 2 == 1, seed % 3 == 0).problem;
    const VectorXd f = 0.5 * p.limit;
    const double s = p.squeeze ? 1.5 : 0.0;
    Matrix6d K_o;
    const bool is_definite = object_stiffness(p, f, s, K_o);
    EXPECT_EQ(is_definite, least_value(dense_posture(p, f, s)) > 0.0);
    if (is_definite) {
      const Matrix6d expected = dense_stiffness(p, f, s);
      EXPECT_LE((K_o - expected).norm(), 1e-9 * expected.norm());
    }
    int first = 0;
    for (int k = 0; k < std::ssize(p.joints); first += p.joints[k++]) {
      const int n = p.joints[k];
      const MatrixXd expected = dense_posture(p, f, s).block(first, first, n, n);
      EXPECT_LE((finger_stiffness(p, k, f, s).topLeftCorner(n, n) - expected).norm(), 1e-12 * expected.norm());
    }
  }
}

// K_o is concave: along a line it lies above its chords.
TEST(StiffProof, StiffnessIsConcaveInTheForces) {
  Random random(5);
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    SCOPED_TRACE(seed);
    const StiffMuscleData p = drawn(seed, true, true).problem;
    VectorXd a(p.H.cols()), b(p.H.cols());
    for (Index j = 0; j < a.size(); ++j) a[j] = random.uniform() * p.limit[j], b[j] = random.uniform() * p.limit[j];
    Matrix6d K_a, K_b, K_m;
    if (!object_stiffness(p, a, 0.0, K_a) || !object_stiffness(p, b, 1.0, K_b)) continue;
    ASSERT_TRUE(object_stiffness(p, 0.5 * (a + b), 0.5, K_m));
    EXPECT_GE(least_value(on_length(K_m - 0.5 * (K_a + K_b), p.length_m)), -1e-9 * K_m.norm());
  }
}

// ---- Proofs in words ----------------------------------------------------------------------------------------------

// What a proof says to be lacking is lacking: less of K_des by a little less than it is infeasible, too.
TEST(StiffProof, WhatLacksIsProved) {
  int proved = 0;
  for (std::uint64_t seed = 6300; seed < 6360; ++seed) {
    SCOPED_TRACE(seed);
    StiffDraw draw = drawn(seed, seed % 2 == 1);
    draw.want(12.0);
    const Solution solution = solve(draw.problem);
    if (solution.report.status != MuscleStatus::kInfeasible || solution.report.cause != StiffCause::kStiffness)
      continue;
    const StiffLack lack = stiff_lack(draw.problem, solution.report);
    EXPECT_GT(lack.lacking_N_per_m, 0.0);
    EXPECT_NEAR(lack.direction.norm(), 1.0, 1e-12);
    StiffMuscleData less = draw.problem;
    const Matrix6d unit = on_length(Matrix6d::Identity(), 1.0 / draw.problem.length_m);
    less.K_des -= 0.999 * lack.lacking_N_per_m * unit;
    EXPECT_EQ(solve(less).report.status, MuscleStatus::kInfeasible);
    // The best proof says more, and there is no better one.
    const StiffLack most = find_stiff_lack(draw.problem);
    EXPECT_GE(most.lacking_N_per_m, lack.lacking_N_per_m * (1.0 - 1e-12));
    less.K_des = draw.problem.K_des - 1.002 * most.lacking_N_per_m * unit;
    EXPECT_EQ(solve(less).report.status, MuscleStatus::kOptimal);
    ++proved;
  }
  EXPECT_GT(proved, 10);
}

TEST(StiffProof, TorquesOutOfReachAreToldAsSuch) {
  StiffDraw draw = drawn(1);
  draw.problem.tau *= 100.0;
  const Solution solution = solve(draw.problem);
  expect_infeasible(draw.problem, solution);
  EXPECT_EQ(solution.report.cause, StiffCause::kTorques);
  EXPECT_TRUE(solution.report.Z.isZero(0.0));
}

TEST(StiffProof, PosturesThatGiveWayAreTold) {
  StiffDraw draw = drawn(1);
  draw.want(-1e6);
  draw.problem.kappa = 1e3;
  const Solution solution = solve(draw.problem);
  expect_infeasible(draw.problem, solution);
  EXPECT_EQ(solution.report.cause, StiffCause::kPosture);
  const StiffLack lack = stiff_lack(draw.problem, solution.report);
  EXPECT_GE(lack.finger, 0);
  EXPECT_NEAR(lack.bend.norm(), 1.0, 1e-12);
  EXPECT_GT(lack.lacking_Nm_per_rad, 0.0);
}

}  // namespace
}  // namespace thenar::stiff_proof_test
