#include "solvers/muscles/stiff_muscles.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <limits>
#include <numeric>
#include <vector>

#include "bench/cases/stiff_problems.h"
#include "solvers/muscles/stiff_proof.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/json_eigen.h"

namespace thenar::stiff_muscles_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Solution {
  StiffMuscleReport report;
  VectorXd f;
};

Solution solve(const StiffMuscleProblem& problem) {
  VectorXd f = VectorXd::Constant(problem.H.cols(), std::numeric_limits<double>::quiet_NaN());
  const StiffMuscleReport report = solve_stiff_muscles(problem, f);
  return {report, f};
}

// ---- The laws once more, dense and plain -------------------------------------------------------------------------

MatrixXd turn_of(const StiffMuscleData& p, int finger, Index muscle) {
  Index pair = 0;
  for (int k = 0; k < finger; ++k) pair += p.joints[k] * (p.joints[k] + 1) / 2;
  const int n = p.joints[finger];
  MatrixXd G(n, n);
  for (int i = 0; i < n; ++i) {
    for (int c = 0; c <= i; ++c) G(i, c) = G(c, i) = p.turn(pair++, muscle);
  }
  return G;
}

/// D + M of all joints, block diagonal.
MatrixXd dense_posture(const StiffMuscleData& p, const VectorXd& f, double s) {
  MatrixXd P = MatrixXd::Zero(p.H.rows(), p.H.rows());
  int first = 0;
  for (int k = 0; k < std::ssize(p.joints); first += p.joints[k++]) {
    const int n = p.joints[k];
    MatrixXd block = p.D.block(first, first, n, n);
    if (p.squeeze) block += s * p.squeeze->D.block(first, first, n, n);
    for (Index j = 0; j < f.size(); ++j) {
      const VectorXd a = p.arm.col(j).segment(first, n);
      block +=
          f[j] / (1.0 / p.fibre_per_m[j] + f[j] / p.tendon_N_per_m[j]) * a * a.transpose() - f[j] * turn_of(p, k, j);
    }
    P.block(first, first, n, n) = block;
  }
  return P;
}

Matrix6d dense_stiffness(const StiffMuscleData& p, const VectorXd& f, double s) {
  MatrixXd A = p.A, B = p.B;
  if (p.squeeze) A += s * p.squeeze->A, B += s * p.squeeze->B;
  return A - B * dense_posture(p, f, s).inverse() * B.transpose();
}

double least_value(const MatrixXd& S) { return Eigen::SelfAdjointEigenSolver<MatrixXd>(S).eigenvalues()[0]; }

Matrix6d on_length(const Matrix6d& X, double length_m) {
  Vector6d arms;
  arms << 1.0, 1.0, 1.0, Eigen::Vector3d::Constant(1.0 / length_m);
  return arms.asDiagonal() * X * arms.asDiagonal();
}

/// <Z, K_o> + sum <Y_k, M_k>, of which the gradient is taken by differences.
double weighed(const StiffMuscleData& p, const StiffMuscleReport& r, const VectorXd& f, double s) {
  double sum = r.Z.cwiseProduct(dense_stiffness(p, f, s)).sum();
  const MatrixXd P = dense_posture(p, f, s);
  int first = 0;
  for (int k = 0; k < std::ssize(p.joints); first += p.joints[k++]) {
    const int n = p.joints[k];
    sum += r.Y[k].topLeftCorner(n, n).cwiseProduct(P.block(first, first, n, n)).sum();
  }
  return sum;
}

/// Karush-Kuhn-Tucker. Differences of 1e-4 N are right to 1e-7 of their size.
void expect_optimal(const StiffMuscleData& p, const Solution& solution) {
  const auto& [r, f] = solution;
  ASSERT_EQ(r.status, MuscleStatus::kOptimal);
  EXPECT_LE(r.residual, 1e-9);
  const double s = r.squeeze, size_N = 1.0 + f.norm(), effort = size_N * size_N;
  VectorXd torque_error = p.H * f - p.tau;
  if (p.squeeze) torque_error -= s * p.squeeze->tau;
  EXPECT_LE(torque_error.cwiseAbs().maxCoeff(), 1e-10 * size_N);
  const Matrix6d slack = dense_stiffness(p, f, s) - p.K_des;
  const double wanted = on_length(p.K_des, p.length_m).cwiseAbs().maxCoeff();
  EXPECT_GE(least_value(on_length(slack, p.length_m)), -1e-9 * wanted);
  EXPECT_GE(least_value(dense_posture(p, f, s)), p.kappa - 1e-9);
  EXPECT_GE(least_value(on_length(r.Z, 1.0 / p.length_m)), -1e-9 * effort / wanted);
  EXPECT_LE(std::abs(r.Z.cwiseProduct(slack).sum()), 1e-8 * effort);
  const auto slope = [&](Index j) {
    const double h = 1e-4;
    VectorXd up = f, down = f;
    double s_up = s, s_down = s;
    (j < f.size() ? up[j] : s_up) += h;
    (j < f.size() ? down[j] : s_down) -= h;
    return (weighed(p, r, up, s_up) - weighed(p, r, down, s_down)) / (2.0 * h);
  };
  // Weights are stiff where they are large: the differences have the rounding of Z K_o.
  const double rounding_N = 1e-10 * r.Z.cwiseProduct(p.A).cwiseAbs().sum() + 1e-5 * size_N;
  for (Index j = 0; j < f.size(); ++j) {
    const double pull = p.H.col(j).dot(r.multiplier) + slope(j);
    EXPECT_NEAR(f[j], std::min(std::max(0.0, pull), p.limit[j]), rounding_N) << "muscle " << j;
  }
  if (!p.squeeze) return;
  const double pull = (slope(f.size()) - p.squeeze->tau.dot(r.multiplier)) / p.squeeze->weight;
  EXPECT_NEAR(s, std::clamp(pull, p.squeeze->low, p.squeeze->high), rounding_N);
}

double effort(const StiffMuscleData& p, const Solution& solution) {
  const double s = solution.report.squeeze;
  return 0.5 * solution.f.squaredNorm() + (p.squeeze ? 0.5 * p.squeeze->weight * s * s : 0.0);
}

/// The most that a sum of conditions can be within the limits, from below: samples of each muscle's part, which are
/// concave. No forces are where it is less than nothing.
double most_of_proof(const StiffMuscleData& p, const StiffMuscleReport& r) {
  double most = r.Z.cwiseProduct(p.A - p.K_des).sum() - p.tau.dot(r.multiplier);
  VectorXd slopes = p.H.transpose() * r.multiplier, stiff = VectorXd::Zero(p.H.cols());
  double squeeze = p.squeeze ? r.Z.cwiseProduct(p.squeeze->A).sum() - p.squeeze->tau.dot(r.multiplier) : 0.0;
  int first = 0;
  for (int k = 0; k < std::ssize(p.joints); first += p.joints[k++]) {
    const int n = p.joints[k];
    const MatrixXd W = (r.bend[k] + r.Y[k]).topLeftCorner(n, n), Q = r.motion[k].leftCols(n);
    // The weights are of squares: each block is positive semidefinite.
    MatrixXd all(6 + n, 6 + n);
    all << r.Z, Q, Q.transpose(), r.bend[k].topLeftCorner(n, n);
    EXPECT_GE(least_value(all), -1e-9 * all.trace());
    EXPECT_GE(least_value(r.Y[k]), -1e-9 * (1e-300 + r.Y[k].trace()));
    most += W.cwiseProduct(p.D.block(first, first, n, n)).sum() - p.kappa * r.Y[k].trace() -
            2.0 * Q.cwiseProduct(p.B.middleCols(first, n)).sum();
    if (p.squeeze) {
      squeeze += W.cwiseProduct(p.squeeze->D.block(first, first, n, n)).sum() -
                 2.0 * Q.cwiseProduct(p.squeeze->B.middleCols(first, n)).sum();
    }
    for (Index j = 0; j < slopes.size(); ++j) {
      const VectorXd a = p.arm.col(j).segment(first, n);
      slopes[j] -= W.cwiseProduct(turn_of(p, k, j)).sum();
      stiff[j] += a.dot(W * a);
    }
  }
  for (Index j = 0; j < slopes.size(); ++j) {
    double best = 0.0;
    for (int i = 0; i <= 1000; ++i) {
      const double f = p.limit[j] * i / 1000.0;
      best = std::max(best, slopes[j] * f + stiff[j] * f / (1.0 / p.fibre_per_m[j] + f / p.tendon_N_per_m[j]));
    }
    most += best;
  }
  if (p.squeeze) most += std::max(squeeze * p.squeeze->low, squeeze * p.squeeze->high);
  return most;
}

void expect_infeasible(const StiffMuscleData& p, const Solution& solution) {
  ASSERT_EQ(solution.report.status, MuscleStatus::kInfeasible);
  EXPECT_LT(solution.report.residual, 1.0);
  EXPECT_TRUE(solution.f.hasNaN()) << "f must be left as it was";
  EXPECT_LT(most_of_proof(p, solution.report), 0.0);
}

StiffDraw drawn(std::uint64_t seed, bool has_tendons = false, bool has_squeeze = false) {
  StiffDraw draw;
  draw.has_tendons = has_tendons;
  draw.has_squeeze = has_squeeze;
  draw.draw(seed);
  return draw;
}

// ---- Against the reference ----------------------------------------------------------------------------------------

// Drawn here by the same generator. The interior points are good to 1e-11 of the effort.
TEST(StiffMuscles, AgreeWithTheInteriorPoints) {
  int infeasible = 0, bound = 0;
  for (const auto& row : read_json(THENAR_TEST_DATA "/stiff_muscles.json")) {
    SCOPED_TRACE(row.at("seed"));
    StiffDraw draw;
    draw.fingers = row.at("fingers");
    draw.joints = row.at("joints");
    draw.muscles = row.at("muscles");
    draw.has_tendons = row.at("tendons");
    draw.has_squeeze = row.at("squeeze");
    draw.draw(row.at("seed").get<std::uint64_t>());
    draw.want(row.at("theta"));
    const Solution solution = solve(draw.problem);
    if (row.at("status") == "infeasible") {
      expect_infeasible(draw.problem, solution);
      ++infeasible;
      continue;
    }
    expect_optimal(draw.problem, solution);
    const double expected = row.at("effort");
    EXPECT_NEAR(effort(draw.problem, solution), expected, 1e-6 * expected);
    // The problem is strongly convex: f is as near as the root of the error of the effort.
    EXPECT_LE((solution.f - vector_of(row.at("f"))).norm(), 1e-4 * solution.f.norm());
    if (draw.has_squeeze) {
      EXPECT_NEAR(solution.report.squeeze, row.at("s"), 1e-4);
    }
    bound += solution.report.Z.isZero(0.0) ? 0 : 1;
  }
  EXPECT_EQ(infeasible, 40);
  EXPECT_GT(bound, 100);
}

// ---- Derivatives --------------------------------------------------------------------------------------------------

TEST(StiffMuscles, StiffnessIsThatOfTheLaw) {
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
TEST(StiffMuscles, StiffnessIsConcaveInTheForces) {
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

// ---- Properties ---------------------------------------------------------------------------------------------------

TEST(StiffMuscles, EveryAnswerIsProvedAndMoreStiffnessNeverTakesLess) {
  int optimal = 0, infeasible = 0, postures = 0;
  for (std::uint64_t seed = 5000; seed < 5100; ++seed) {
    SCOPED_TRACE(seed);
    StiffDraw draw = drawn(seed, seed % 2 == 1, seed % 3 == 0);
    if (seed % 4 == 1) draw.problem.kappa = 0.3;  // Postures bind, too.
    double last = 0.0;
    bool was_possible = true;
    for (const double theta : {0.5, 1.0, 2.0, 4.0, 8.0}) {
      SCOPED_TRACE(theta);
      draw.want(theta);
      const Solution solution = solve(draw.problem);
      ASSERT_NE(solution.report.status, MuscleStatus::kBudgetSpent);
      if (solution.report.status == MuscleStatus::kInfeasible) {
        expect_infeasible(draw.problem, solution);
        was_possible = false;
        ++infeasible;
        continue;
      }
      ASSERT_TRUE(was_possible) << "less stiffness was found to be too much";
      expect_optimal(draw.problem, solution);
      EXPECT_GE(effort(draw.problem, solution), last * (1.0 - 1e-9));
      last = effort(draw.problem, solution);
      ++optimal;
      for (int k = 0; k < draw.fingers; ++k) postures += solution.report.Y[k].isZero(0.0) ? 0 : 1;
    }
  }
  EXPECT_GT(optimal, 100);
  EXPECT_GT(infeasible, 50);
  EXPECT_GT(postures, 20);
}

// Forces that are stiff enough as they are have the bits of those without a wish.
TEST(StiffMuscles, WithoutNeedOfStiffnessAreTheLeastForces) {
  int equal = 0;
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    SCOPED_TRACE(seed);
    StiffDraw draw = drawn(seed);
    draw.want(-1e6);
    draw.problem.kappa = -1e6;
    draw.problem.limit *= 0.2;
    // No finger gives way.
    draw.problem.D += 100.0 * MatrixXd::Identity(12, 12);
    VectorXd f = VectorXd::Zero(23);
    const MuscleReport alone = solve_muscle_forces({draw.problem.H, draw.problem.tau, draw.problem.limit}, f);
    const Solution solution = solve(draw.problem);
    ASSERT_EQ(solution.report.status, alone.status);
    if (alone.status != MuscleStatus::kOptimal) continue;
    EXPECT_EQ(solution.f, f);
    ++equal;
  }
  EXPECT_GT(equal, 25);
}

TEST(StiffMuscles, TheOrderOfMusclesHasNoMeaning) {
  for (std::uint64_t seed = 6000; seed < 6030; ++seed) {
    SCOPED_TRACE(seed);
    StiffDraw draw = drawn(seed, true);
    draw.want(1.0);
    const Solution first = solve(draw.problem);
    std::vector<Index> order(23);
    std::iota(order.begin(), order.end(), 0);
    Random random(seed);
    for (Index j = 22; j > 0; --j) std::swap(order[j], order[random.whole(0, j)]);
    StiffMuscleData p = draw.problem;
    p.H = draw.problem.H(Eigen::all, order);
    p.arm = draw.problem.arm(Eigen::all, order);
    p.turn = draw.problem.turn(Eigen::all, order);
    p.limit = draw.problem.limit(order);
    p.fibre_per_m = draw.problem.fibre_per_m(order);
    p.tendon_N_per_m = draw.problem.tendon_N_per_m(order);
    const Solution second = solve(p);
    ASSERT_EQ(first.report.status, second.report.status);
    if (first.report.status != MuscleStatus::kOptimal) continue;
    EXPECT_LE((second.f - first.f(order)).norm(), 1e-6 * first.f.norm());
  }
}

// Tendons in series take stiffness away: the same wish takes more effort, and very stiff ones nothing.
TEST(StiffMuscles, TendonsTakeEffort) {
  int compared = 0;
  for (std::uint64_t seed = 6100; seed < 6130; ++seed) {
    SCOPED_TRACE(seed);
    StiffDraw draw = drawn(seed, true);
    draw.want(1.0);
    StiffMuscleData rigid = draw.problem, stiff = draw.problem;
    rigid.tendon_N_per_m.setConstant(kInfinity);
    stiff.tendon_N_per_m *= 1e9;
    const Solution soft_one = solve(draw.problem), rigid_one = solve(rigid), stiff_one = solve(stiff);
    if (soft_one.report.status != MuscleStatus::kOptimal) continue;
    ASSERT_EQ(rigid_one.report.status, MuscleStatus::kOptimal);
    ASSERT_EQ(stiff_one.report.status, MuscleStatus::kOptimal);
    EXPECT_GE(effort(draw.problem, soft_one), effort(rigid, rigid_one) * (1.0 - 1e-9));
    EXPECT_NEAR(effort(stiff, stiff_one), effort(rigid, rigid_one), 1e-6 * effort(rigid, rigid_one));
    ++compared;
  }
  EXPECT_GT(compared, 10);
}

// A squeeze that may be anything takes no more effort than one that may not.
TEST(StiffMuscles, TheSqueezeIsChosen) {
  int compared = 0;
  for (std::uint64_t seed = 6200; seed < 6270; ++seed) {
    SCOPED_TRACE(seed);
    StiffDraw draw = drawn(seed, false, true);
    draw.want(1.0);
    const Solution free = solve(draw.problem);
    StiffMuscleData held = draw.problem;
    held.squeeze->low = held.squeeze->high = 1.0;
    const Solution fixed = solve(held);
    if (fixed.report.status != MuscleStatus::kOptimal) continue;
    ASSERT_EQ(free.report.status, MuscleStatus::kOptimal);
    EXPECT_EQ(fixed.report.squeeze, 1.0);
    EXPECT_LE(effort(draw.problem, free), effort(held, fixed) * (1.0 + 1e-9));
    ++compared;
  }
  EXPECT_GT(compared, 10);
}

// ---- Proofs in words ----------------------------------------------------------------------------------------------

// What a proof says to be lacking is lacking: less of K_des by a little less than it is infeasible, too.
TEST(StiffMuscles, WhatLacksIsProved) {
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

TEST(StiffMuscles, TorquesOutOfReachAreToldAsSuch) {
  StiffDraw draw = drawn(1);
  draw.problem.tau *= 100.0;
  const Solution solution = solve(draw.problem);
  expect_infeasible(draw.problem, solution);
  EXPECT_EQ(solution.report.cause, StiffCause::kTorques);
  EXPECT_TRUE(solution.report.Z.isZero(0.0));
}

TEST(StiffMuscles, PosturesThatGiveWayAreTold) {
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

// ---- In a loop ----------------------------------------------------------------------------------------------------

// A loop of torques and wishes that drift: from the last optimum the answer is that from nothing.
TEST(StiffMuscles, FromTheLastOptimumItIsTheSame) {
  StiffWarmStart last;
  int warm_steps = 0, cold_steps = 0;
  StiffDraw draw = drawn(6001);
  const VectorXd tau = draw.problem.tau;
  for (int period = 0; period < 200; ++period) {
    SCOPED_TRACE(period);
    draw.problem.tau = (1.0 + 0.2 * std::sin(0.02 * period)) * tau;
    draw.want(1.0 + 0.3 * std::sin(0.03 * period));
    VectorXd f(23);
    const StiffMuscleReport warm = solve_stiff_muscles(draw.problem, last, f);
    const Solution cold = solve(draw.problem);
    ASSERT_EQ(warm.status, cold.report.status);
    ASSERT_EQ(warm.status, MuscleStatus::kOptimal);
    EXPECT_LE((f - cold.f).norm(), 1e-7 * f.norm());
    warm_steps += warm.iterations;
    cold_steps += cold.report.iterations;
  }
  EXPECT_LT(3 * warm_steps, cold_steps);
}

TEST(StiffMuscles, DoNotAllocateAndRepeatTheirBits) {
  if (!AllocationCounter::is_available()) GTEST_SKIP() << "malloc is not ours";
  StiffDraw draw = drawn(6001, true, true), hopeless = drawn(6001);
  draw.want(1.0);
  hopeless.want(100.0);
  VectorXd f(23), again(23);
  StiffWarmStart last;
  const AllocationCounter counter;
  EXPECT_EQ(solve_stiff_muscles(draw.problem, f).status, MuscleStatus::kOptimal);
  EXPECT_EQ(solve_stiff_muscles(draw.problem, last, again).status, MuscleStatus::kOptimal);
  EXPECT_EQ(f, again);
  const StiffMuscleReport report = solve_stiff_muscles(hopeless.problem, again);
  EXPECT_EQ(report.status, MuscleStatus::kInfeasible);
  (void)stiff_lack(hopeless.problem, report);
  EXPECT_EQ(solve_stiff_muscles(draw.problem, last, again).status, MuscleStatus::kOptimal);
  EXPECT_EQ(counter.count(), 0);
}

TEST(StiffMuscles, NotFiniteInputIsRefused) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  StiffDraw draw = drawn(6001, true, true);
  draw.want(1.0);
  const auto expect_refused = [](const StiffMuscleData& p) {
    const Solution solution = solve(p);
    EXPECT_EQ(solution.report.status, MuscleStatus::kBudgetSpent);
    EXPECT_TRUE(solution.f.hasNaN()) << "f must be left as it was";
  };
  for (const double bad : {nan, kInfinity}) {
    for (int which = 0; which < 9; ++which) {
      SCOPED_TRACE(which);
      StiffMuscleData p = draw.problem;
      double* const number[] = {&p.H(2, 2), &p.tau[3],  &p.arm(1, 1), &p.turn(3, 3), &p.fibre_per_m[1],
                                &p.A(1, 2), &p.B(2, 3), &p.D(1, 1),   &p.K_des(0, 0)};
      *number[which] = bad;
      expect_refused(p);
    }
    StiffMuscleData p = draw.problem;
    p.squeeze->tau[1] = bad;
    expect_refused(p);
  }
  StiffMuscleData p = draw.problem;
  p.limit[2] = nan;
  expect_refused(p);
  p = draw.problem;
  p.limit[2] = -1.0;
  expect_refused(p);
  p = draw.problem;
  p.tendon_N_per_m[2] = 0.0;
  expect_refused(p);
}

// As many joints and muscles as there may be, and fingers of different sizes.
TEST(StiffMuscles, OfTheLargestHand) {
  StiffDraw draw;
  draw.fingers = 6;
  draw.joints = 5;
  draw.muscles = 64;
  draw.has_squeeze = true;
  draw.draw(3);
  draw.want(0.5);
  const Solution solution = solve(draw.problem);
  expect_optimal(draw.problem, solution);
}

}  // namespace
}  // namespace thenar::stiff_muscles_test
