// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace thenar {

// Decompositions for oracles, compiled once: Eigen's own templates take seconds in every source that names them.

/// A^+, from a complete orthogonal decomposition.
Eigen::MatrixXd pseudo_inverse(const Eigen::MatrixXd& A);

/// The shortest x with least |A x - b|.
Eigen::VectorXd least_squares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);

/// Columns that span all x with A x = 0; one column of zeros where there is none.
Eigen::MatrixXd null_space(const Eigen::MatrixXd& A);

/// Of a symmetric matrix, the least first.
Eigen::VectorXd eigenvalues(const Eigen::MatrixXd& symmetric);

bool is_positive_definite(const Eigen::MatrixXd& symmetric);

}  // namespace thenar
