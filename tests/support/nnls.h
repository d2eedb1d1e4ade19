// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace thenar {

/// Non-negative least squares, min |B x - b| over x >= 0, by Lawson and Hanson's active set: the tests' oracle for
/// cones, which shares nothing with Lemke's method.
Eigen::VectorXd nonnegative_least_squares(const Eigen::MatrixXd& B, const Eigen::VectorXd& b);

/// The distance of b from the cone that the columns of B span.
double distance_from_cone(const Eigen::MatrixXd& B, const Eigen::VectorXd& b);

/// How far a gradient is from being balanced by equality rows G (any sign) and active rows A (pushing only):
///     min |gradient - G'l - A'g| over l and g >= 0.
/// Zero at the optimum of a convex problem with G f = W, A f >= 0, and there only.
double stationarity_error(const Eigen::VectorXd& gradient, const Eigen::MatrixXd& G, const Eigen::MatrixXd& A_active);

}  // namespace thenar
