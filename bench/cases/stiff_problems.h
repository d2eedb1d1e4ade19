// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cmath>

#include "bench/cases/random.h"
#include "solvers/grasp_problem.h"
#include "solvers/muscles/stiff_problem.h"

namespace thenar {

/// Random problems of muscle effort under an object stiffness: fingers around an object of 44 mm, each with the springs
/// of its fingertip. tests/solvers/stiff_muscles_reference.py has the same generator.
struct StiffDraw {
  int fingers = 3, joints = 4;  ///< The joints are those of one finger.
  int muscles = 23;
  bool has_tendons = false, has_squeeze = false;
  StiffMuscleData problem = {};

  void draw(std::uint64_t seed);
  /// K_des becomes so many times the one that was drawn.
  void want(double theta) { problem.K_des = theta * wanted; }

  Matrix6d wanted = Matrix6d::Zero();

 private:
  static Eigen::MatrixXd symmetric(Random& random, int n, double size) {
    Eigen::MatrixXd S(n, n);
    for (int i = 0; i < n; ++i) {
      for (int c = 0; c <= i; ++c) S(i, c) = S(c, i) = random.uniform(-size, size);
    }
    return S;
  }
  void add_finger(Random& random, int k);
  void add_muscle(Random& random, int j);
  void add_squeeze(Random& random);
};

inline void StiffDraw::add_finger(Random& random, int k) {
  using Eigen::Matrix3d;
  using Eigen::Vector3d;
  const int n = joints;
  const double side = k == 0 ? -1.0 : 1.0, spread = k > 0 ? 0.02 * (k - 0.5 * fingers) : 0.0;
  Vector3d point, normal;
  point[0] = 0.022 * side;
  point[1] = spread + random.uniform(-3e-3, 3e-3);
  point[2] = random.uniform(-3e-3, 3e-3);
  normal[0] = -side;
  normal[1] = random.uniform(-0.2, 0.2);
  normal[2] = random.uniform(-0.2, 0.2);
  normal /= std::sqrt(normal.dot(normal));
  const double stiff = random.uniform(2000.0, 5000.0);
  const Matrix3d nn = normal * normal.transpose(), I = Matrix3d::Identity();
  Matrix6d spring = Matrix6d::Zero();
  spring.topLeftCorner<3, 3>() = stiff * (nn + 0.67 * (I - nn));
  spring.bottomRightCorner<3, 3>() = 1e-5 * stiff * (nn + 0.5 * (I - nn));
  Matrix6Xd J(6, n);
  for (int c = 0; c < n; ++c) {
    Vector3d arm, axis;
    arm[0] = side * random.uniform(0.0, 0.02);
    arm[1] = random.uniform(-0.01, 0.01);
    arm[2] = -0.09 * (n - c) / n;
    axis << (c == 0 ? 1.0 : 0.1), (c == 0 ? 0.1 : 1.0), random.uniform(-0.2, 0.2);
    axis /= std::sqrt(axis.dot(axis));
    J.col(c) << axis.cross(arm), axis;
  }
  Matrix6d grasp = Matrix6d::Identity();
  grasp.bottomLeftCorner<3, 3>() << 0.0, -point[2], point[1], point[2], 0.0, -point[0], -point[1], point[0], 0.0;
  problem.A += grasp * spring * grasp.transpose();
  problem.B.middleCols(k * n, n) = grasp * spring * J;
  problem.D.block(k * n, k * n, n, n) =
      J.transpose() * spring * J + symmetric(random, n, 0.01) - 0.02 * Eigen::MatrixXd::Identity(n, n);
}

inline void StiffDraw::add_muscle(Random& random, int j) {
  const int n = joints, own = j % fingers, turn = j / fingers;
  problem.fibre_per_m[j] = 23.4 / random.uniform(0.04, 0.08);
  problem.tendon_N_per_m[j] = random.uniform(2e4, 2e5);
  problem.limit[j] = random.uniform(60.0, 250.0);
  for (int part = 0; part < 2; ++part) {
    if (part == 1 && !random.chance(0.08)) break;
    const int k = (own + part) % fingers;
    for (int c = 0; c < n; ++c) {
      const double arm = random.uniform(3e-3, 12e-3);
      const bool is_crossed = turn < 2 || random.chance(0.8);
      const bool is_negative = random.chance(0.5);
      const double sign = turn < 2 && c > 0 ? (turn == 0 ? 1.0 : -1.0) : (is_negative ? -1.0 : 1.0);
      problem.H(k * n + c, j) = is_crossed ? sign * arm : 0.0;
    }
    const Eigen::MatrixXd G = symmetric(random, n, 3e-3);
    for (int i = 0, p = k * n * (n + 1) / 2; i < n; ++i) {
      for (int c = 0; c <= i; ++c) problem.turn(p++, j) = G(i, c);
    }
  }
}

inline void StiffDraw::add_squeeze(Random& random) {
  StiffSqueeze squeeze;
  const int n = joints, all = fingers * joints;
  Eigen::VectorXd f(muscles);
  for (int j = 0; j < muscles; ++j) f[j] = random.uniform();
  squeeze.tau = problem.H * f;
  squeeze.A.bottomRightCorner<3, 3>() = symmetric(random, 3, 0.01) - 0.01 * Eigen::Matrix3d::Identity();
  squeeze.A.topLeftCorner<3, 3>() = 200.0 * Eigen::Matrix3d::Identity();
  squeeze.B.setZero(6, all);
  squeeze.D.setZero(all, all);
  for (int k = 0; k < fingers; ++k) {
    squeeze.D.block(k * n, k * n, n, n) = symmetric(random, n, 0.004);
    for (int i = 0; i < 6; ++i) {
      for (int c = 0; c < n; ++c) squeeze.B(i, k * n + c) = random.uniform(-0.5, 0.5);
    }
  }
  squeeze.low = 0.0;
  squeeze.high = 5.0;
  squeeze.weight = 20.0;
  problem.squeeze = squeeze;
}

inline void StiffDraw::draw(std::uint64_t seed) {
  Random random(seed);
  const int all = fingers * joints;
  problem = {};
  problem.joints.assign(fingers, joints);
  problem.B.setZero(6, all);
  problem.D.setZero(all, all);
  for (int k = 0; k < fingers; ++k) add_finger(random, k);
  problem.A.bottomRightCorner<3, 3>() += symmetric(random, 3, 0.02) - 0.06 * Eigen::Matrix3d::Identity();
  problem.H.setZero(all, muscles);
  problem.turn.setZero(all * (joints + 1) / 2, muscles);
  problem.fibre_per_m.resize(muscles);
  problem.tendon_N_per_m.resize(muscles);
  problem.limit.resize(muscles);
  for (int j = 0; j < muscles; ++j) add_muscle(random, j);
  problem.arm = problem.H;
  if (!has_tendons) problem.tendon_N_per_m.setConstant(std::numeric_limits<double>::infinity());
  Eigen::VectorXd f(muscles);
  for (int j = 0; j < muscles; ++j) {
    const double part = random.uniform();
    f[j] = 0.1 * problem.limit[j] * part * part;
  }
  problem.tau = problem.H * f;
  const Matrix6d off = symmetric(random, 6, 10.0);
  Vector6d lengths;
  lengths << 1.0, 1.0, 1.0, Eigen::Vector3d::Constant(0.025);
  wanted = lengths.asDiagonal() * (100.0 * Matrix6d::Identity() + off) * lengths.asDiagonal();
  problem.kappa = 0.005;
  if (has_squeeze) add_squeeze(random);
}

}  // namespace thenar
