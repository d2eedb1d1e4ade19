// SPDX-License-Identifier: Apache-2.0
#include "collision/ellipsoid.h"

#include <algorithm>
#include <cmath>

namespace thenar {

using Eigen::Index;
using Eigen::Vector3d;

// The point is x_i = e_i^2 y_i / (s + e_i^2 - e_2^2), e_2 the least semi-axis, with the largest s that puts it on the
// surface [Eberly, Distance from a point to an ellipsoid]. The sum of the squares (x_i / e_i)^2 is convex in s and
// falls: Newton's steps from below it approach it from below.
Vector3d nearest_on_ellipsoid(const Vector3d& e, const Vector3d& y) noexcept {
  Index least = 0;
  const double e_2 = e.minCoeff(&least);
  // Where y is in the middle plane across the least semi-axis, both sides may be equally near.
  Vector3d z = y.cwiseAbs();
  z[least] = std::max(z[least], 1e-13 * e_2);
  const Vector3d above = (e.cwiseAbs2().array() - e_2 * e_2).matrix();
  const Vector3d ez = e.cwiseProduct(z);
  double s = (ez - above).maxCoeff();
  constexpr int kMostSteps = 100;
  for (int step = 0; step < kMostSteps; ++step) {
    const Vector3d ratio = ez.cwiseQuotient((above.array() + s).matrix());
    const double value = ratio.squaredNorm() - 1.0;
    const double slope = -2.0 * ratio.cwiseAbs2().cwiseQuotient((above.array() + s).matrix()).sum();
    const double next = s - value / slope;
    if (!(next > s)) break;
    s = next;
  }
  Vector3d x = e.cwiseAbs2().cwiseProduct(z).cwiseQuotient((above.array() + s).matrix());
  for (Index i = 0; i < 3; ++i) x[i] = std::copysign(x[i], y[i]);
  return x;
}

}  // namespace thenar
