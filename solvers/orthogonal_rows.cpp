// SPDX-License-Identifier: Apache-2.0
#include "solvers/orthogonal_rows.h"

#include <cmath>
#include <limits>

namespace thenar {

using Eigen::Index;

namespace {

/// Rotates rows (or columns, by `step`s) a and b of length n by an angle of cosine c and sine s.
void turn(double* a, double* b, Index n, Index step, double c, double s) {
  for (Index i = 0; i < n * step; i += step) {
    const double x = a[i], y = b[i];
    a[i] = c * x - s * y;
    b[i] = s * x + c * y;
  }
}

}  // namespace

void orthogonalize_rows(Eigen::Ref<Eigen::MatrixXd> A, Eigen::Ref<Eigen::MatrixXd> U) noexcept {
  // It converges quadratically, in 5 to 8 rounds; what is not a number would go round for ever.
  constexpr int kMostRounds = 60;
  constexpr double kOrthogonal = std::numeric_limits<double>::epsilon();
  U.setIdentity();
  for (int round = 0; round < kMostRounds; ++round) {
    bool turned = false;
    for (Index i = 0; i < A.rows(); ++i) {
      for (Index j = i + 1; j < A.rows(); ++j) {
        double ii = 0.0, jj = 0.0, ij = 0.0;
        for (Index k = 0; k < A.cols(); ++k) {
          ii += A(i, k) * A(i, k);
          jj += A(j, k) * A(j, k);
          ij += A(i, k) * A(j, k);
        }
        if (!(std::abs(ij) > kOrthogonal * std::sqrt(ii) * std::sqrt(jj))) continue;
        // The smaller of the two angles that make the rows orthogonal.
        const double zeta = (jj - ii) / (2.0 * ij);
        const double t = std::copysign(1.0, zeta) / (std::abs(zeta) + std::sqrt(1.0 + zeta * zeta));
        const double c = 1.0 / std::sqrt(1.0 + t * t);
        turn(&A(i, 0), &A(j, 0), A.cols(), A.outerStride(), c, c * t);
        turn(&U(0, i), &U(0, j), U.rows(), 1, c, c * t);
        turned = true;
      }
    }
    if (!turned) return;
  }
}

}  // namespace thenar
