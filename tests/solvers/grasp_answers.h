// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>
#include <vector>

#include "solvers/grasp_forces.h"
#include "tests/support/algebra.h"
#include "tests/support/grasp_problems.h"

/// How grasp problems with the pyramid are solved, and the proofs of the answers.
namespace thenar::grasp_answers {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// c of eq. (15).
inline VectorXd bias_of(const Grasp& grasp) {
  VectorXd c(3 * grasp.n());
  for (Index i = 0; i < grasp.n(); ++i) {
    c.segment<3>(3 * i) = -internal_force_of(grasp, i) * grasp.contacts[i].axes.col(0);
  }
  return c;
}

struct Solution {
  GraspReport report;
  VectorXd f;
};

inline Solution solve(const Grasp& grasp) {
  VectorXd f = VectorXd::Constant(3 * grasp.n(), std::numeric_limits<double>::quiet_NaN());
  const GraspReport report = solve_grasp_forces(grasp.problem(FrictionCone::kPyramid), f);
  return {report, f};
}

inline Solution solve_by_lemke(const Grasp& grasp) {
  GraspWorkspace work;
  VectorXd f = VectorXd::Constant(3 * grasp.n(), std::numeric_limits<double>::quiet_NaN());
  const GraspReport report = solve_grasp_forces_by_lemke(grasp.problem(FrictionCone::kPyramid), work, f);
  return {report, f};
}

/// The point of the pyramid nearest to y (contact axes), by trying all its faces, edges and the tip: the projections on
/// them, of which the nearest inside the pyramid is it.
inline Vector3d nearest_in_pyramid(double mu, const Vector3d& y) {
  std::vector<MatrixXd> faces{MatrixXd(0, 3), MatrixXd::Identity(3, 3)};
  for (const double u : {-1.0, 1.0}) {
    faces.push_back(Eigen::RowVector3d(mu, u, 0.0));
    faces.push_back(Eigen::RowVector3d(mu, 0.0, u));
    for (const double v : {-1.0, 1.0}) faces.push_back((MatrixXd(2, 3) << mu, u, 0.0, mu, 0.0, v).finished());
  }
  Vector3d nearest = Vector3d::Zero();
  for (const MatrixXd& A : faces) {
    Vector3d point = y;
    if (A.rows() > 0) point -= pseudo_inverse(A) * (A * y);
    const bool inside = point.tail<2>().cwiseAbs().maxCoeff() <= mu * point[0] + 1e-14 * y.norm() && point[0] >= 0.0;
    if (inside && (point - y).norm() < (nearest - y).norm()) nearest = point;
  }
  return nearest;
}

/// Karush-Kuhn-Tucker with the multiplier that the solver gave: G f = W, and f_i = P_K(G_i'l - c_i). Forces are a few
/// newtons to some tens (near the border of feasibility), and a dozen changes on rows of order 1 amplify rounding by
/// less than 1e4: 1e-10 is on the safe side, and a wrong set of tight rows leaves errors of the forces' own size.
inline void expect_optimal(const Grasp& grasp, const Solution& solution, double tolerance = 1e-10) {
  const VectorXd& f = solution.f;
  const double size = f.norm() + bias_of(grasp).norm();
  const MatrixXd G = grasp_map(grasp);
  EXPECT_LE((G.topRows(3) * f - grasp.wrench.head<3>()).norm(), tolerance * size);
  EXPECT_LE((G.bottomRows(3) * f - grasp.wrench.tail<3>()).norm(), tolerance * size * G.bottomRows(3).norm());
  EXPECT_GE((pyramid_rows(grasp) * f).minCoeff(), -tolerance * size);
  const VectorXd pulled = G.transpose() * solution.report.multiplier - bias_of(grasp);
  EXPECT_LE(solution.report.residual, 1e-9 + 1e-11 * pulled.norm() / size);
  EXPECT_LE(grasp_kkt_error(grasp.problem(FrictionCone::kPyramid), solution.report.multiplier, f),
            std::max(1e-9, tolerance) + 1e-11 * pulled.norm() / size);
  // Cones so thin that forces must be far larger than the wrench: the multiplier is larger still, and distances from
  // it, which the trials below compare, round by more than they differ.
  if (pulled.norm() > 1e2 * size) return;
  for (Index i = 0; i < grasp.n(); ++i) {
    const Matrix3d& frame = grasp.contacts[i].axes;
    const Vector3d pulled_C = frame.transpose() * pulled.segment<3>(3 * i);
    const Vector3d nearest = frame * nearest_in_pyramid(friction_of(grasp, i), pulled_C);
    EXPECT_LE((f.segment<3>(3 * i) - nearest).norm(), tolerance * size);
  }
}

/// The twist that the solver gave moves with the wrench, and against every edge of every pyramid: any forces inside
/// them do no work on it where the wrench would have to.
inline void expect_infeasible(const Grasp& grasp, const Solution& solution, double tolerance = 1e-10) {
  const Vector6d& twist = solution.report.multiplier;
  const MatrixXd G = grasp_map(grasp);
  const VectorXd velocities = G.transpose() * twist;
  // What the velocities are the sums of.
  const double size = (G.cwiseAbs().transpose() * twist.cwiseAbs()).norm();
  EXPECT_GT(grasp.wrench.dot(twist), 0.0);
  EXPECT_LE((pyramid_edges(grasp).transpose() * velocities).maxCoeff(), tolerance * size);
  // Forces 1e8 times the least that would do without cones count as none.
  EXPECT_LE(solution.report.residual, 1e-8);
  EXPECT_LE(infeasibility_gap(grasp.problem(FrictionCone::kPyramid), twist), std::max(1e-8, tolerance));
  EXPECT_TRUE(solution.f.hasNaN()) << "f must be left as it was";
}

/// Expects one of both answers, with its proof.
inline void expect_proved(const Grasp& grasp, const Solution& solution, double tolerance = 1e-10) {
  ASSERT_NE(solution.report.status, GraspStatus::kBudgetSpent);
  if (solution.report.status == GraspStatus::kOptimal) {
    expect_optimal(grasp, solution, tolerance);
  } else {
    expect_infeasible(grasp, solution, tolerance);
  }
}

/// Box corners and whole numbers: rows of A coincide, ratios tie, optima lie on many rows at once.
inline Grasp degenerate_grasp(unsigned seed, double friction) {
  std::mt19937 random(seed);
  const auto whole = [&] { return static_cast<double>(random() % 3) - 1.0; };
  Grasp grasp;
  for (unsigned i = 0; i < 2 + seed % 5; ++i) {
    const Index face = random() % 3;
    const double side = random() % 2 == 0 ? 1.0 : -1.0;
    Vector3d point(0.02 * whole(), 0.02 * whole(), 0.02 * whole());
    point[face] = 0.02 * side;
    Matrix3d frame;
    frame << -side * Vector3d::Unit(face), Vector3d::Unit((face + 1) % 3), -side * Vector3d::Unit((face + 2) % 3);
    grasp.contacts.push_back({point, frame});
  }
  grasp.wrench << whole(), whole(), whole(), 0.02 * whole(), 0.02 * whole(), 0.02 * whole();
  grasp.friction = friction;
  grasp.internal_force_N = static_cast<double>(seed % 2);
  return grasp;
}

/// Forces inside the pyramids that need not be the optimum, and the wrench they give: so the grasp is feasible.
inline Grasp held(Grasp grasp, const VectorXd& f_inside) {
  grasp.wrench = grasp_map(grasp) * f_inside;
  return grasp;
}

/// For each contact a force n + t1 friction a + t2 friction b with a, b drawn from [-edge, edge].
inline VectorXd forces_inside(const Grasp& grasp, double edge, std::mt19937& random) {
  std::uniform_real_distribution<double> share(-edge, edge);
  std::uniform_real_distribution<double> normal_N(0.5, 3.0);
  VectorXd f(3 * grasp.n());
  for (Index i = 0; i < grasp.n(); ++i) {
    const double mu = friction_of(grasp, i);
    f.segment<3>(3 * i) =
        normal_N(random) * (grasp.contacts[i].axes * Vector3d(1.0, mu * share(random), mu * share(random)));
  }
  return f;
}

}  // namespace thenar::grasp_answers
