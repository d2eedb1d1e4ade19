// SPDX-License-Identifier: Apache-2.0
#include "tests/support/algebra.h"

#include <Eigen/Dense>

namespace thenar {

using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd pseudo_inverse(const MatrixXd& A) { return A.completeOrthogonalDecomposition().pseudoInverse(); }

VectorXd least_squares(const MatrixXd& A, const VectorXd& b) { return A.completeOrthogonalDecomposition().solve(b); }

MatrixXd null_space(const MatrixXd& A) { return A.fullPivLu().kernel(); }

VectorXd eigenvalues(const MatrixXd& symmetric) {
  return Eigen::SelfAdjointEigenSolver<MatrixXd>(symmetric, Eigen::EigenvaluesOnly).eigenvalues();
}

bool is_positive_definite(const MatrixXd& symmetric) { return symmetric.llt().info() == Eigen::Success; }

}  // namespace thenar
