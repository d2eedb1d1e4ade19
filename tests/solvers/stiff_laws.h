// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "bench/cases/stiff_problems.h"
#include "solvers/muscles/stiff_muscles.h"

/// The laws of muscle effort under an object stiffness once more, dense and plain, for its tests.
namespace thenar::stiff_laws {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Solution {
  StiffMuscleReport report;
  VectorXd f;
};

inline Solution solve(const StiffMuscleProblem& problem) {
  VectorXd f = VectorXd::Constant(problem.H.cols(), std::numeric_limits<double>::quiet_NaN());
  const StiffMuscleReport report = solve_stiff_muscles(problem, f);
  return {report, f};
}

inline MatrixXd turn_of(const StiffMuscleData& p, int finger, Index muscle) {
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
inline MatrixXd dense_posture(const StiffMuscleData& p, const VectorXd& f, double s) {
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

inline Matrix6d dense_stiffness(const StiffMuscleData& p, const VectorXd& f, double s) {
  MatrixXd A = p.A, B = p.B;
  if (p.squeeze) A += s * p.squeeze->A, B += s * p.squeeze->B;
  return A - B * dense_posture(p, f, s).inverse() * B.transpose();
}

inline double least_value(const MatrixXd& S) { return Eigen::SelfAdjointEigenSolver<MatrixXd>(S).eigenvalues()[0]; }

inline Matrix6d on_length(const Matrix6d& X, double length_m) {
  Vector6d arms;
  arms << 1.0, 1.0, 1.0, Eigen::Vector3d::Constant(1.0 / length_m);
  return arms.asDiagonal() * X * arms.asDiagonal();
}

/// <Z, K_o> + sum <Y_k, M_k>, of which the gradient is taken by differences.
inline double weighed(const StiffMuscleData& p, const StiffMuscleReport& r, const VectorXd& f, double s) {
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
inline void expect_optimal(const StiffMuscleData& p, const Solution& solution) {
  const StiffMuscleReport& r = solution.report;
  const VectorXd& f = solution.f;
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

inline double effort(const StiffMuscleData& p, const Solution& solution) {
  const double s = solution.report.squeeze;
  return 0.5 * solution.f.squaredNorm() + (p.squeeze ? 0.5 * p.squeeze->weight * s * s : 0.0);
}

/// The most that a sum of conditions can be within the limits, from below: samples of each muscle's part, which are
/// concave. No forces are where it is less than nothing.
inline double most_of_proof(const StiffMuscleData& p, const StiffMuscleReport& r) {
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

inline void expect_infeasible(const StiffMuscleData& p, const Solution& solution) {
  ASSERT_EQ(solution.report.status, MuscleStatus::kInfeasible);
  EXPECT_LT(solution.report.residual, 1.0);
  EXPECT_TRUE(solution.f.hasNaN()) << "f must be left as it was";
  EXPECT_LT(most_of_proof(p, solution.report), 0.0);
}

inline StiffDraw drawn(std::uint64_t seed, bool has_tendons = false, bool has_squeeze = false) {
  StiffDraw draw;
  draw.has_tendons = has_tendons;
  draw.has_squeeze = has_squeeze;
  draw.draw(seed);
  return draw;
}

}  // namespace thenar::stiff_laws
