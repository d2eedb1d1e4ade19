#include "engine/problem_check.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "solvers/lcp.h"
#include "solvers/residual.h"

namespace thenar {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

// A muscle that pulls with less than this part of all forces rests: what may keep it from pushing is not missed.
constexpr double kRests = 1e-12;

/// Zero if nothing is wrong, whatever the scale.
double share(double error, double scale) { return error == 0.0 ? 0.0 : error / scale; }

/// x >= 0 of least |B x - b|, by the LCP of its normal equations: how near it comes to the least does not matter here,
/// only that no x comes nearer than the least.
VectorXd nonnegative_least_squares(const MatrixXd& B, const VectorXd& b) {
  VectorXd x = VectorXd::Zero(B.cols());
  if (B.cols() == 0) return x;
  LcpWorkspace work(B.cols());
  const MatrixXd M = B.transpose() * B;
  const VectorXd q = -B.transpose() * b;
  std::ignore = solve_lcp(M, q, usual_pivot_budget(B.cols()), work, x);
  return x;
}

/// rho_i q_i of the natural map, all contacts.
VectorXd scaled_gaps(const ContactFile& problem, const VectorXd& delta) {
  VectorXd scaled(delta.size());
  for (Index i = 0; i < problem.contacts(); ++i) {
    const double rho_i = 3.0 / problem.W.block<3, 3>(3 * i, 3 * i).trace();
    scaled.segment<3>(3 * i) = rho_i * delta.segment<3>(3 * i);
  }
  return scaled;
}

}  // namespace

ContactResidual contact_residual(const ContactFile& problem, Index step, const VectorXd& f) {
  const VectorXd& delta_free = problem.delta_free[static_cast<std::size_t>(step)];
  const double scale_N = scaled_gaps(problem, delta_free).norm();
  const VectorXd rho_delta = scaled_gaps(problem, problem.W * f + delta_free);
  double sum = 0.0, worst = 0.0;  // squared [N^2]
  for (Index i = 0; i < problem.contacts(); ++i) {
    const Vector3d f_i = f.segment<3>(3 * i);
    Vector3d moved = f_i - rho_delta.segment<3>(3 * i);
    moved[0] -= problem.mu[i] * rho_delta.segment<2>(3 * i + 1).norm();
    const double error = (f_i - project_on_cone(moved, problem.mu[i])).squaredNorm();
    sum += error;
    worst = std::isnan(error) ? error : std::max(worst, error);
  }
  return {share(std::sqrt(sum), scale_N), share(std::sqrt(worst), scale_N)};
}

double muscle_residual(const MuscleFile& problem, const VectorXd& f) {
  const auto H = problem.H.completeOrthogonalDecomposition();
  // What no forces can give counts, too: H H^+ leaves it out.
  const VectorXd torque_error = problem.H * f - problem.tau;
  const VectorXd made_up = H.solve(torque_error);
  const double beyond = share((torque_error - problem.H * made_up).norm(), problem.tau.norm());

  std::vector<Index> resting;
  for (Index i = 0; i < f.size(); ++i) {
    if (f[i] <= kRests * f.norm()) resting.push_back(i);
  }
  // pi, the part of forces that gives no torque, is the part that H'l cannot balance.
  const MatrixXd pi = MatrixXd::Identity(f.size(), f.size()) - H.solve(problem.H);
  const MatrixXd B = pi(Eigen::all, resting);
  const VectorXd left = pi * f - B * nonnegative_least_squares(B, pi * f);
  const double largest = std::max({made_up.norm(), -f.minCoeff(), left.norm()});
  return std::max(beyond, share(largest, f.norm()));
}

double lcp_residual(const LcpFile& problem, const VectorXd& z) {
  const double m = problem.M.cwiseAbs().maxCoeff();
  const VectorXd w = problem.M * z + problem.q;
  const double error = w.cwiseMin(m * z).cwiseAbs().maxCoeff();
  return share(error, problem.q.cwiseAbs().maxCoeff() + m * z.cwiseAbs().sum());
}

ContactCertificate contact_certificate(const ContactFile& problem, Index step) {
  const Index n = problem.contacts();
  const VectorXd& delta_free = problem.delta_free[static_cast<std::size_t>(step)];
  const auto normals = Eigen::seqN(0, n, 3);
  const MatrixXd W_nn = problem.W(normals, normals);
  const VectorXd q_n = delta_free(normals);
  ContactCertificate certificate{VectorXd::Zero(n)};
  LcpWorkspace work(n);
  if (solve_lcp(W_nn, q_n, usual_pivot_budget(n), work, certificate.y).status != LcpStatus::kInfeasible) {
    certificate.y.setZero();
    return certificate;
  }
  certificate.y /= certificate.y.maxCoeff();
  certificate.closed_m = -certificate.y.dot(q_n);
  if (certificate.closed_m <= 0.0) return certificate;
  VectorXd moved = VectorXd::Zero(3 * n);
  for (Index i = 0; i < n; ++i) moved += certificate.y[i] * problem.W.row(3 * i).transpose();
  certificate.gap = scaled_gaps(problem, delta_free).norm() * moved.norm() / certificate.closed_m;
  return certificate;
}

MuscleDeficit explain_infeasible_muscles(const MuscleFile& problem) {
  MuscleDeficit deficit;
  const VectorXd nearest = nonnegative_least_squares(problem.H, problem.tau);
  deficit.missing_Nm = problem.tau - problem.H * nearest;
  const double done = deficit.missing_Nm.dot(problem.tau);
  if (done <= 0.0) return deficit;
  const VectorXd H_r = problem.H.transpose() * deficit.missing_Nm;
  const VectorXd least = problem.H.completeOrthogonalDecomposition().solve(problem.tau);
  deficit.gap = least.norm() * H_r.cwiseMax(0.0).norm() / done;
  return deficit;
}

double lcp_infeasibility_gap(const LcpFile& problem, const VectorXd& y) {
  const double done = -y.dot(problem.q);
  if (done <= 0.0 || y.minCoeff() < 0.0) return std::numeric_limits<double>::infinity();
  const double left = (problem.M.transpose() * y).cwiseMax(0.0).norm();
  return share(problem.q.cwiseAbs().maxCoeff() * left, problem.M.cwiseAbs().maxCoeff() * done);
}

}  // namespace thenar
