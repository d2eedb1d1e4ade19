// SPDX-License-Identifier: Apache-2.0
#include "solvers/orthogonal_rows.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace thenar::orthogonal_rows_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

MatrixXd random_matrix(std::mt19937& random, Index rows, Index columns) {
  std::normal_distribution<double> normal;
  return MatrixXd::NullaryExpr(rows, columns, [&] { return normal(random); });
}

// U is orthogonal, U' A is what is returned, and its rows are orthogonal: to rounding, 1e-16 times the number of
// products.
TEST(OrthogonalRows, KeepTheMatrixAndAreOrthogonal) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const Index rows = 1 + seed % 12, columns = 1 + (seed * 7) % 30;
    const MatrixXd A = random_matrix(random, rows, columns);
    MatrixXd turned = A, U(rows, rows);
    orthogonalize_rows(turned, U);
    const double rounding = 1e-14 * A.norm();
    EXPECT_LE((U.transpose() * U - MatrixXd::Identity(rows, rows)).norm(), 1e-13);
    EXPECT_LE((U.transpose() * A - turned).norm(), 10.0 * rounding);
    MatrixXd products = turned * turned.transpose();
    products.diagonal().setZero();
    EXPECT_LE(products.cwiseAbs().maxCoeff(), rounding * A.norm());
  }
}

// Of U diag(s) V' with known s they are found to a few digits of rounding each, however far apart they are: A's rows
// are scaled here, which is what one-sided rotations keep.
TEST(OrthogonalRows, HaveTheSingularValuesAsLengths) {
  const std::vector<double> values = {1e-9, 1e-6, 1e-3, 1.0, 1e3};
  const Index n = std::ssize(values);
  // Rows of a Hadamard-like orthogonal basis, by the discrete cosine transform.
  MatrixXd V(n, n);
  for (Index i = 0; i < n; ++i) {
    for (Index k = 0; k < n; ++k) {
      const double angle = M_PI * static_cast<double>(i) * (static_cast<double>(k) + 0.5) / static_cast<double>(n);
      V(i, k) = std::sqrt((i == 0 ? 1.0 : 2.0) / static_cast<double>(n)) * std::cos(angle);
    }
  }
  MatrixXd A(n, n), U(n, n);
  for (Index i = 0; i < n; ++i) A.row(i) = values[static_cast<std::size_t>(i)] * V.row(i);
  A.row(4) += 0.5 * values[3] * V.row(3);  // no longer orthogonal
  orthogonalize_rows(A, U);
  std::vector<double> found(static_cast<std::size_t>(n));
  for (Index i = 0; i < n; ++i) found[static_cast<std::size_t>(i)] = A.row(i).norm();
  std::sort(found.begin(), found.end());
  // The product of all is the determinant, which the last line has left alone.
  double product = 1.0, expected = 1.0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    product *= found[i];
    expected *= values[i];
    EXPECT_NEAR(found[i], values[i], 1e-6 * values[i]) << i;
  }
  EXPECT_NEAR(product, expected, 1e-12 * expected);
}

// A row that depends on others gives a length of zero, but for rounding.
TEST(OrthogonalRows, ShowDependentRows) {
  std::mt19937 random(3);
  MatrixXd A = random_matrix(random, 6, 9), U(6, 6);
  A.row(5) = A.row(0) - 2.0 * A.row(3);
  orthogonalize_rows(A, U);
  EXPECT_LE(A.rowwise().norm().minCoeff(), 1e-14 * A.norm());
}

TEST(OrthogonalRows, EndOnWhatIsNoNumber) {
  MatrixXd A = MatrixXd::Constant(3, 3, std::nan("")), U(3, 3);
  orthogonalize_rows(A, U);
  EXPECT_TRUE(A.hasNaN());
}

}  // namespace
}  // namespace thenar::orthogonal_rows_test
