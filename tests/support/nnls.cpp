// SPDX-License-Identifier: Apache-2.0
#include "tests/support/nnls.h"

#include <Eigen/Dense>
#include <algorithm>
#include <vector>

namespace thenar {

Eigen::VectorXd nonnegative_least_squares(const Eigen::MatrixXd& B, const Eigen::VectorXd& b) {
  using Eigen::Index;
  using Eigen::VectorXd;
  const double zero = 1e-13 * (1.0 + B.cwiseAbs().sum()) * (1.0 + b.norm());
  VectorXd x = VectorXd::Zero(B.cols());
  std::vector<Index> passive;

  const auto least_squares = [&] {
    const VectorXd x_passive = B(Eigen::all, passive).colPivHouseholderQr().solve(b);
    VectorXd all = VectorXd::Zero(B.cols());
    for (std::size_t k = 0; k < passive.size(); ++k) all[passive[k]] = x_passive[static_cast<Index>(k)];
    return all;
  };

  for (int iteration = 0; iteration < 10 * B.cols(); ++iteration) {
    VectorXd gain = B.transpose() * (b - B * x);
    for (const Index k : passive) gain[k] = 0.0;
    Index best = 0;
    if (B.cols() == 0 || gain.maxCoeff(&best) <= zero) break;
    passive.push_back(best);

    VectorXd target = least_squares();
    while (!passive.empty() && target(passive).minCoeff() <= 0.0) {
      double step = 1.0;
      for (const Index k : passive) {
        if (target[k] <= 0.0) step = std::min(step, x[k] / (x[k] - target[k]));
      }
      x += step * (target - x);
      std::erase_if(passive, [&](Index k) { return target[k] <= 0.0 && x[k] <= 1e-14 * (1.0 + x.maxCoeff()); });
      VectorXd kept = VectorXd::Zero(B.cols());
      for (const Index k : passive) kept[k] = x[k];
      x = kept;
      target = least_squares();
    }
    x = target;
  }
  return x;
}

double distance_from_cone(const Eigen::MatrixXd& B, const Eigen::VectorXd& b) {
  return (b - B * nonnegative_least_squares(B, b)).norm();
}

double stationarity_error(const Eigen::VectorXd& gradient, const Eigen::MatrixXd& G, const Eigen::MatrixXd& A_active) {
  const Eigen::MatrixXd G_pinv = G.completeOrthogonalDecomposition().pseudoInverse();
  const Eigen::MatrixXd pi = Eigen::MatrixXd::Identity(G.cols(), G.cols()) - G_pinv * G;
  return distance_from_cone(pi * A_active.transpose(), pi * gradient);
}

}  // namespace thenar
