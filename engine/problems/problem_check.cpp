// SPDX-License-Identifier: Apache-2.0
#include "engine/problems/problem_check.h"

#include <Eigen/Core>
#include <algorithm>
#include <limits>
#include <tuple>
#include <vector>

#include "solvers/orthogonal_rows.h"

namespace thenar {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using MatrixRef = Eigen::Ref<const MatrixXd>;

namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

// A muscle that pulls with less than this part of all forces is idle, and may have a multiplier against pushing.
constexpr double kRests = 1e-12;

// Contacts that deviate from a line by less than this part of their distances count as collinear, as in the solver.
constexpr double kNoPower = 1e-10;

/// Returns a relative error; zero without error, at any scale.
double part_of(double error, double scale) { return error == 0.0 ? 0.0 : error / scale; }

/// Returns rho_i delta_i of every contact [N], rho_i = 3 / tr(W_ii); zero where no force moves a contact.
VectorXd scaled_by_rho(const MatrixRef& W, VectorXd delta) {
  for (Index i = 0; i < delta.size(); i += 3) {
    const double trace = W(i, i) + W(i + 1, i + 1) + W(i + 2, i + 2);
    // Divided first: 1 / trace may overflow where the quotient does not.
    delta.segment<3>(i) = trace > 0.0 ? Vector3d(3.0 * (delta.segment<3>(i) / trace)) : Vector3d::Zero();
  }
  return delta;
}

/// Returns x >= 0 of least |B x - b|, by the LCP of its normal equations. Its accuracy does not matter here, only that
/// no x is better than the optimum.
VectorXd nonnegative_least_squares(const MatrixRef& B, const VectorXd& b) {
  VectorXd x = VectorXd::Zero(B.cols());
  if (B.cols() == 0) return x;
  LcpWorkspace work(B.cols());
  const LcpData normal{B.transpose() * B, -B.transpose() * b};
  std::ignore = solve_lcp(normal, usual_pivot_budget(B.cols()), work, x);
  return x;
}

/// The pseudo-inverse A^+ of a matrix with fewer rows than columns, by its singular values.
class PseudoInverse {
 public:
  explicit PseudoInverse(const MatrixRef& A) : rows_(A), U_(A.rows(), A.rows()) {
    orthogonalize_rows(rows_, U_);
    lengths_ = rows_.rowwise().norm();
    // A row that depends on others, up to rounding.
    const double none = std::numeric_limits<double>::epsilon() * static_cast<double>(A.cols()) * lengths_.maxCoeff();
    for (Index i = 0; i < lengths_.size(); ++i) {
      if (lengths_[i] > none) {
        rows_.row(i) /= lengths_[i];
      } else {
        rows_.row(i).setZero();
        U_.col(i).setZero();
        lengths_[i] = 1.0;
      }
    }
  }

  /// Returns A^+ b.
  [[nodiscard]] VectorXd of(const VectorXd& b) const {
    return rows_.transpose() * (U_.transpose() * b).cwiseQuotient(lengths_);
  }
  /// Returns A^+ A x, the part of x in A's row space.
  [[nodiscard]] VectorXd seen(const VectorXd& x) const { return rows_.transpose() * (rows_ * x); }

 private:
  MatrixXd rows_, U_;
  VectorXd lengths_;
};

}  // namespace

Residual contact_residual(const ContactProblem& problem, const VectorXd& f) {
  const VectorXd delta = problem.W * f + problem.delta_free;
  const VectorXd pulled = scaled_by_rho(problem.W, delta);
  VectorXd errors(problem.mu.size());
  const double touching = touching_m(problem.delta_free);
  for (Index i = 0; i < errors.size(); ++i) {
    // As in the solvers: no force opens this contact.
    if (problem.W(3 * i, 3 * i) == 0.0 && problem.delta_free[3 * i] < -touching) return {kInfinite, kInfinite};
    const Vector3d f_i = f.segment<3>(3 * i);
    Vector3d moved = f_i - pulled.segment<3>(3 * i);
    moved[0] -= problem.mu[i] * pulled.segment<2>(3 * i + 1).norm();
    errors[i] = (f_i - project_on_cone(moved, problem.mu[i])).norm();
  }
  const double scale_N = scaled_by_rho(problem.W, problem.delta_free).stableNorm();
  // With extreme units the squares may not fit a double.
  return {part_of(errors.stableNorm(), scale_N), part_of(errors.lpNorm<Eigen::Infinity>(), scale_N)};
}

double grasp_rounding(const GraspProblem& problem) {
  const Index n = std::ssize(problem.contacts);
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  for (const GraspContact& contact : problem.contacts) centre_m += contact.point_m / static_cast<double>(n);
  MatrixXd G(6, 3 * n);
  grasp_map(problem.contacts, centre_m, G);
  const double size_m = G.bottomRows<3>().norm();
  if (size_m > 0.0) G.bottomRows<3>() /= size_m;
  MatrixXd U(6, 6);
  orthogonalize_rows(G, U);
  const VectorXd values = G.rowwise().norm();
  const double largest = values.maxCoeff();
  double condition = 1.0;
  for (const double value : values) {
    if (value > kNoPower * largest) condition = std::max(condition, largest / value);
  }
  return std::numeric_limits<double>::epsilon() * condition;
}

double muscle_residual(const MuscleProblem& problem, const VectorXd& f) {
  const PseudoInverse H(problem.H);
  // Torques that no forces can give count, too: H H^+ removes them.
  const VectorXd torque_error = problem.H * f - problem.tau;
  const VectorXd made_up = H.of(torque_error);
  const double beyond = part_of((torque_error - problem.H * made_up).norm(), problem.tau.norm());

  std::vector<VectorXd> pushes;  // Those at their limits push back.
  const double beyond_limit = problem.limit.size() > 0 ? (f - problem.limit).maxCoeff() : 0.0;
  for (Index i = 0; i < f.size(); ++i) {
    if (f[i] <= kRests * f.norm()) pushes.push_back(VectorXd::Unit(f.size(), i));
    if (f[i] >= problem.limit_of(i) - kRests * f.norm()) pushes.push_back(-VectorXd::Unit(f.size(), i));
  }
  // pi, the part of forces that gives no torque, is the part that H'l cannot balance.
  const auto pi = [&H](const VectorXd& x) -> VectorXd { return x - H.seen(x); };
  MatrixXd B(f.size(), std::ssize(pushes));
  for (Index c = 0; c < B.cols(); ++c) B.col(c) = pi(pushes[static_cast<std::size_t>(c)]);
  const VectorXd left = pi(f) - B * nonnegative_least_squares(B, pi(f));
  const double largest = std::max({made_up.norm(), -f.minCoeff(), beyond_limit, left.norm()});
  return std::max(beyond, part_of(largest, f.norm()));
}

double lcp_residual(const LcpProblem& problem, const VectorXd& z) {
  const double m = problem.M.cwiseAbs().maxCoeff();
  const VectorXd w = problem.M * z + problem.q;
  const double error = w.cwiseMin(m * z).cwiseAbs().maxCoeff();
  return part_of(error, problem.q.cwiseAbs().maxCoeff() + m * z.cwiseAbs().sum());
}

ContactVerdict contact_verdict(const ContactProblem& problem, const VectorXd& y) {
  ContactVerdict verdict;
  VectorXd moved = VectorXd::Zero(problem.delta_free.size());
  for (Index i = 0; i < y.size(); ++i) {
    verdict.closed_m -= y[i] * problem.delta_free[3 * i];
    moved += y[i] * problem.W.row(3 * i).transpose();
  }
  if (y.minCoeff() >= 0.0 && verdict.closed_m > 0.0) {
    verdict.gap = scaled_by_rho(problem.W, problem.delta_free).stableNorm() * moved.stableNorm() / verdict.closed_m;
  }
  return verdict;
}

MuscleDeficit explain_infeasible_muscles(const MuscleProblem& problem) {
  MuscleDeficit deficit;
  const VectorXd nearest = nonnegative_least_squares(problem.H, problem.tau);
  deficit.missing_Nm = problem.tau - problem.H * nearest;
  const double done = deficit.missing_Nm.dot(problem.tau);
  if (done <= 0.0) return deficit;
  const VectorXd H_r = problem.H.transpose() * deficit.missing_Nm;
  const VectorXd least = PseudoInverse(problem.H).of(problem.tau);
  deficit.gap = least.norm() * H_r.cwiseMax(0.0).norm() / done;
  return deficit;
}

double lcp_infeasibility_gap(const LcpProblem& problem, const VectorXd& y) {
  const double done = -y.dot(problem.q);
  if (done <= 0.0 || y.minCoeff() < 0.0) return kInfinite;
  const double left = (problem.M.transpose() * y).cwiseMax(0.0).norm();
  return part_of(problem.q.cwiseAbs().maxCoeff() * left, problem.M.cwiseAbs().maxCoeff() * done);
}

}  // namespace thenar
