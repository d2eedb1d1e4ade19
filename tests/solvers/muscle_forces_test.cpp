// SPDX-License-Identifier: Apache-2.0
#include "solvers/muscles/muscle_forces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <random>
#include <vector>

#include "bench/cases/grasp_families.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/json_eigen.h"
#include "tests/support/nnls.h"

namespace thenar::muscle_forces_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Solution {
  MuscleReport report;
  VectorXd f;
};

VectorXd untouched(Index muscles) { return VectorXd::Constant(muscles, std::numeric_limits<double>::quiet_NaN()); }

Solution solve(const MuscleProblem& problem) {
  VectorXd f = untouched(problem.H.cols());
  const MuscleReport report = solve_muscle_forces(problem, f);
  return {report, f};
}

Solution solve_by_lemke(const MuscleProblem& problem) {
  MuscleWorkspace work(problem.H.rows(), problem.H.cols());
  VectorXd f = untouched(problem.H.cols());
  const MuscleReport report = solve_muscle_forces_by_lemke(problem, work, f);
  return {report, f};
}

MatrixXd random_matrix(Index rows, Index cols, std::mt19937& random) {
  std::normal_distribution<double> normal;
  return MatrixXd::NullaryExpr(rows, cols, [&] { return normal(random); });
}

/// Lever arms of about 1 cm.
MatrixXd random_arms(std::mt19937& random) { return 0.01 * random_matrix(12, 23, random); }

/// Karush-Kuhn-Tucker. Lever arms of 1 cm and forces of newtons: torques round at 1e-18 a term, and a condition number
/// of H of 100 leaves 1e-12 of the forces' size. A muscle counts as idle below 1e-9 of it.
void expect_optimal(const MatrixXd& H, const VectorXd& tau, const VectorXd& f) {
  const double size_N = 1.0 + f.norm();
  EXPECT_GE(f.minCoeff(), 0.0);
  EXPECT_LE((H * f - tau).cwiseAbs().maxCoeff(), 1e-12 * size_N);
  MatrixXd pushes(0, f.size());
  for (Index j = 0; j < f.size(); ++j) {
    if (f[j] >= 1e-9 * size_N) continue;
    pushes.conservativeResize(pushes.rows() + 1, Eigen::NoChange);
    pushes.bottomRows<1>() = VectorXd::Unit(f.size(), j).transpose();
  }
  EXPECT_LE(stationarity_error(f, H, pushes), 1e-8 * size_N);
}

/// The proof in exact terms: at joint velocities l the torques do work, tau.l > 0, and no muscle can: 1e-10 of its arms
/// is the rounding of l.
void expect_infeasible(const MatrixXd& H, const VectorXd& tau, const VectorXd& l) {
  for (Index j = 0; j < H.cols(); ++j) EXPECT_LE(H.col(j).dot(l), 1e-10 * H.col(j).norm() * l.norm());
  EXPECT_GT(tau.dot(l), 0.0);
}

void expect_proved(const MatrixXd& H, const VectorXd& tau, const Solution& solution) {
  ASSERT_NE(solution.report.status, MuscleStatus::kBudgetSpent);
  if (solution.report.status == MuscleStatus::kOptimal) {
    EXPECT_LE(solution.report.residual, 1e-9);
    expect_optimal(H, tau, solution.f);
  } else {
    EXPECT_TRUE(solution.f.hasNaN()) << "f must be left as it was";
    expect_infeasible(H, tau, solution.report.multiplier);
  }
}

TEST(MuscleForces, AgreeWithTheRecordedOptima) {
  for (const auto& problem : recorded_small_problems("P2")) {
    SCOPED_TRACE(problem.at("file"));
    const MatrixXd H = matrix_of(problem.at("H"));
    const VectorXd tau = vector_of(problem.at("tau"));
    const Solution solution = solve({H, tau});
    if (problem.at("status") == "infeasible") {
      EXPECT_EQ(solution.report.status, MuscleStatus::kInfeasible);
      EXPECT_TRUE(solution.f.hasNaN()) << "f must be left as it was";
      continue;
    }
    ASSERT_EQ(solution.report.status, MuscleStatus::kOptimal);
    // Forces of 60 to 200 N: 1e-11 of them.
    EXPECT_LE((solution.f - vector_of(problem.at("f_opt"))).cwiseAbs().maxCoeff(), 1e-9);
  }
}

TEST(MuscleForces, AgreeWithTheHandsReference) {
  const nlohmann::json hand = read_json(THENAR_TEST_DATA "/hand_reference.json");
  const MatrixXd H = matrix_of(hand.at("H"));
  for (const auto& problem : hand.at("muscle")) {
    const VectorXd tau = vector_of(problem.at("tau"));
    const Solution solution = solve({H, tau});
    if (problem.at("f").is_null()) {
      EXPECT_EQ(solution.report.status, MuscleStatus::kInfeasible);
      continue;
    }
    ASSERT_EQ(solution.report.status, MuscleStatus::kOptimal);
    EXPECT_LE((solution.f - vector_of(problem.at("f"))).cwiseAbs().maxCoeff(), 1e-10);
    expect_optimal(H, tau, solution.f);
  }
}

// Random arms without any zero are one block, and often cannot pull every way: both answers occur, and both are proved.
TEST(MuscleForces, EveryAnswerIsProved) {
  int infeasible = 0;
  for (unsigned seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const MatrixXd H = random_arms(random);
    const VectorXd tau = 0.1 * random_matrix(12, 1, random);
    const Solution solution = solve({H, tau});
    expect_proved(H, tau, solution);
    // In units of 1 cm, so that the oracle's zero fits.
    const bool out_of_reach = distance_from_cone(100.0 * H, 100.0 * tau) > 1e-9;
    EXPECT_EQ(solution.report.status == MuscleStatus::kInfeasible, out_of_reach);
    infeasible += out_of_reach ? 1 : 0;
  }
  EXPECT_GT(infeasible, 30);
  EXPECT_LT(infeasible, 270);
}

// The published method and the active set share nothing but H. Lemke's tableau leaves 1e-9 of the forces.
TEST(MuscleForces, AgreeWithLemke) {
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const MuscleData problem = seed % 2 == 0 ? muscle_families::held(random) : muscle_families::any(random);
    const Solution ours = solve(problem);
    const Solution lemke = solve_by_lemke(problem);
    ASSERT_EQ(ours.report.status, lemke.report.status);
    if (ours.report.status == MuscleStatus::kOptimal) {
      EXPECT_LE((ours.f - lemke.f).norm(), 1e-6 * ours.f.norm());
    } else {
      expect_infeasible(problem.H, problem.tau, lemke.report.multiplier);
    }
  }
}

// Joints that share no muscle are problems of their own: each block alone has the same forces. The order of joints and
// muscles has no meaning; rounding may follow it.
TEST(MuscleForces, BlocksAreIndependent) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const MatrixXd A = 0.01 * random_matrix(3, 9, random), B = 0.01 * random_matrix(5, 12, random);
    const VectorXd tau_A = A * random_matrix(9, 1, random).cwiseAbs(),
                   tau_B = B * random_matrix(12, 1, random).cwiseAbs();
    MatrixXd H = MatrixXd::Zero(8, 22);  // One muscle crosses no joint.
    H.topLeftCorner(3, 9) = A;
    H.bottomRightCorner(5, 12) = B;
    VectorXd tau(8);
    tau << tau_A, tau_B;
    std::vector<Index> joints(8), muscles(22);
    std::iota(joints.begin(), joints.end(), 0);
    std::iota(muscles.begin(), muscles.end(), 0);
    std::shuffle(joints.begin(), joints.end(), random);
    std::shuffle(muscles.begin(), muscles.end(), random);
    const Solution whole = solve({H(joints, muscles), tau(joints)});
    ASSERT_EQ(whole.report.status, MuscleStatus::kOptimal);
    VectorXd f(22);
    f(muscles) = whole.f;
    const double size_N = f.norm();
    EXPECT_LE((f.head(9) - solve({A, tau_A}).f).norm(), 1e-11 * size_N);
    EXPECT_LE((f.tail(12) - solve({B, tau_B}).f).norm(), 1e-11 * size_N);
    EXPECT_EQ(f[9], 0.0);
  }
}

// As many joints and muscles as there may be.
TEST(MuscleForces, OfTheLargestHand) {
  std::mt19937 random(1);
  const MatrixXd H = 0.01 * random_matrix(kMaxJoints, kMaxMuscles, random);
  const VectorXd tau = H * random_matrix(kMaxMuscles, 1, random).cwiseAbs();
  expect_proved(H, tau, solve({H, tau}));
}

// Two muscles that pull apart on one joint: only the agonist works. A third of the same arm halves it.
TEST(MuscleForces, OfOneJointByHand) {
  MatrixXd H(1, 3);
  H << 0.01, -0.01, 0.01;
  const Solution flexion = solve({H, VectorXd::Constant(1, 0.2)});
  EXPECT_LE((flexion.f - Eigen::Vector3d(10.0, 0.0, 10.0)).cwiseAbs().maxCoeff(), 1e-13);
  const Solution extension = solve({H, VectorXd::Constant(1, -0.2)});
  EXPECT_LE((extension.f - Eigen::Vector3d(0.0, 20.0, 0.0)).cwiseAbs().maxCoeff(), 1e-13);
}

TEST(MuscleForces, AreZeroWithoutTorque) {
  std::mt19937 random(1);
  const Solution solution = solve({random_arms(random), VectorXd::Zero(12)});
  EXPECT_EQ(solution.report.status, MuscleStatus::kOptimal);
  EXPECT_TRUE(solution.f.isZero(0.0));
}

// A joint whose arms repeat those of others adds nothing if its torque agrees, and cannot be had if not.
TEST(MuscleForces, DependentJointsAreTakenOrRefused) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    MatrixXd H = random_arms(random);
    H.row(5) = H.row(1) - 2.0 * H.row(3);
    H.row(11).setZero();
    const VectorXd tau = H * random_matrix(23, 1, random).cwiseAbs();
    const Solution solution = solve({H, tau});
    ASSERT_EQ(solution.report.status, MuscleStatus::kOptimal);
    expect_optimal(H, tau, solution.f);
    for (const Index joint : {5, 11}) {
      EXPECT_EQ(solve({H, tau + 0.01 * VectorXd::Unit(12, joint)}).report.status, MuscleStatus::kInfeasible);
    }
  }
}

// Torques of a few muscles, at the border of what all can give, where many muscles rest and no force is to spare.
TEST(MuscleForces, TorquesOfFewMusclesAreFound) {
  for (std::uint64_t seed = 1'000'000; seed < 1'001'000; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const MuscleData problem = muscle_families::few(random);
    const Solution solution = solve(problem);
    ASSERT_EQ(solution.report.status, MuscleStatus::kOptimal);
    EXPECT_LE((problem.H * solution.f - problem.tau).cwiseAbs().maxCoeff(), 1e-12 * (1.0 + solution.f.norm()));
    EXPECT_GE(solution.f.minCoeff(), 0.0);
  }
}

/// Karush-Kuhn-Tucker with limits, from the multiplier: f = clamp(H'l, 0, limit).
void expect_optimal_within(const MuscleProblem& p, const Solution& solution) {
  ASSERT_EQ(solution.report.status, MuscleStatus::kOptimal);
  const double size_N = 1.0 + solution.f.norm();
  EXPECT_LE((p.H * solution.f - p.tau).cwiseAbs().maxCoeff(), 1e-11 * size_N);
  const VectorXd pull = p.H.transpose() * solution.report.multiplier;
  EXPECT_LE((solution.f - pull.cwiseMax(0.0).cwiseMin(p.limit)).cwiseAbs().maxCoeff(), 1e-9 * size_N);
}

// The same torques with limits that are lower and lower: the same bits while none binds, then more effort, then a proof
// that is one in exact terms. Lemke's method, which shares nothing with the active set, says the same.
TEST(MuscleForces, LimitsBindOrAreProvedToBeTooLow) {
  int bound = 0, infeasible = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    MuscleData problem = muscle_families::held(random);
    const Solution free = solve(problem);
    ASSERT_EQ(free.report.status, MuscleStatus::kOptimal);
    const double largest_N = free.f.maxCoeff();
    double last = free.f.norm();
    bool was_possible = true;
    for (const double part : {1.0, 0.9, 0.7, 0.5}) {
      SCOPED_TRACE(part);
      problem.limit = VectorXd::Constant(23, part * largest_N);
      if (seed % 2 == 0) problem.limit[random.whole(0, 22)] = std::numeric_limits<double>::infinity();
      const MuscleProblem view = problem;
      const Solution ours = solve(view);
      MuscleWorkspace work(12, 23);
      VectorXd f(23);
      const MuscleReport lemke = solve_muscle_forces_by_lemke(view, work, f);
      ASSERT_EQ(ours.report.status, lemke.status);
      if (ours.report.status == MuscleStatus::kOptimal) {
        ASSERT_TRUE(was_possible || seed % 2 == 0);
        expect_optimal_within(view, ours);
        EXPECT_LE((ours.f - f).norm(), 1e-6 * f.norm());
        if (part == 1.0) {
          EXPECT_EQ(ours.f, free.f);
        }
        EXPECT_GE(ours.f.norm(), (seed % 2 == 0 ? free.f.norm() : last) * (1.0 - 1e-12));
        last = ours.f.norm();
        bound += part < 1.0 ? 1 : 0;
        continue;
      }
      was_possible = false;
      ++infeasible;
      for (const auto& l : {ours.report.multiplier, lemke.multiplier}) {
        double possible = 0.0;
        for (Index j = 0; j < 23; ++j) {
          const double rate = problem.H.col(j).dot(l);
          if (std::isinf(problem.limit[j])) {
            EXPECT_LE(rate, 1e-9 * l.norm());
          } else {
            possible += problem.limit[j] * std::max(0.0, rate);
          }
        }
        EXPECT_GT(problem.tau.dot(l), possible);
        EXPECT_LT(muscle_infeasibility_gap(view, l), 1.0);
      }
      // What a muscle lacks, it lacks: with less than that there are no forces.
      const MuscleLack lack = muscle_lack(view, ours.report.multiplier);
      if (lack.muscle < 0) continue;
      EXPECT_GT(lack.needed_N, problem.limit[lack.muscle]);
      MuscleData more = problem;
      more.limit[lack.muscle] = 0.999 * lack.needed_N;
      EXPECT_EQ(solve(more).report.status, MuscleStatus::kInfeasible);
    }
  }
  EXPECT_GT(bound, 100);
  EXPECT_GT(infeasible, 50);
}

// Two muscles share a joint: the stronger arm is at its limit, and the other gives the rest. Then both are too weak.
TEST(MuscleForces, LimitsByHand) {
  MatrixXd H(1, 2);
  H << 0.02, 0.01;
  const VectorXd tau = VectorXd::Constant(1, 0.5), limit = Eigen::Vector2d(15.0, 30.0);
  const Solution shared = solve({H, tau, limit});
  EXPECT_LE((shared.f - Eigen::Vector2d(15.0, 20.0)).cwiseAbs().maxCoeff(), 1e-12);
  const Solution weak = solve({H, 2.0 * tau, limit});
  ASSERT_EQ(weak.report.status, MuscleStatus::kInfeasible);
  const MuscleLack lack = muscle_lack({H, 2.0 * tau, limit}, weak.report.multiplier);
  // 0.3 N m each: of equal parts the later one.
  EXPECT_EQ(lack.muscle, 1);
  EXPECT_NEAR(lack.needed_N, 70.0, 1e-9);
  EXPECT_NEAR(weak.report.residual, 0.6, 1e-12);
}

TEST(MuscleForces, OfNothing) {
  EXPECT_EQ(solve({MatrixXd(0, 3), VectorXd(0)}).report.status, MuscleStatus::kOptimal);
  EXPECT_EQ(solve({MatrixXd(2, 0), VectorXd::Zero(2)}).report.status, MuscleStatus::kOptimal);
  EXPECT_EQ(solve({MatrixXd(2, 0), VectorXd::Ones(2)}).report.status, MuscleStatus::kInfeasible);
}

TEST(MuscleForces, NotFiniteInputIsRefused) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  std::mt19937 random(1);
  const MatrixXd H = random_arms(random);
  const VectorXd tau = H * VectorXd::Ones(23);
  for (const double bad : {nan, infinity}) {
    MatrixXd bad_H = H;
    bad_H(2, 2) = bad;
    VectorXd bad_tau = tau;
    bad_tau[3] = bad;
    for (const Solution& solution :
         {solve({bad_H, tau}), solve({H, bad_tau}), solve_by_lemke({bad_H, tau}), solve_by_lemke({H, bad_tau})}) {
      EXPECT_EQ(solution.report.status, MuscleStatus::kBudgetSpent);
      EXPECT_TRUE(solution.f.hasNaN()) << "f must be left as it was";
    }
  }
  EXPECT_EQ(solve({H, tau, VectorXd::Constant(23, nan)}).report.status, MuscleStatus::kBudgetSpent);
}

TEST(MuscleForces, DoNotAllocateAndRepeatTheirBits) {
  if (!AllocationCounter::is_available()) GTEST_SKIP() << "malloc is not ours";
  Random random(2);
  const MuscleData problem = muscle_families::held(random);
  MuscleWorkspace work(12, 23);
  VectorXd f(23), again(23);
  const AllocationCounter counter;
  EXPECT_EQ(solve_muscle_forces(problem, f).status, MuscleStatus::kOptimal);
  (void)solve_muscle_forces_by_lemke(problem, work, f);
  (void)solve_muscle_forces(problem, f);
  (void)solve_muscle_forces(problem, again);
  EXPECT_EQ(counter.count(), 0);
  EXPECT_EQ(f, again);
}

}  // namespace
}  // namespace thenar::muscle_forces_test
