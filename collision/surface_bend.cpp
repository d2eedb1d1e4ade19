// SPDX-License-Identifier: Apache-2.0
#include "collision/surface_bend.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace thenar {

using Eigen::Vector3d;

BendFit::BendFit(const Vector3d& p_m, const Vector3d& n, double support_m)
    : p_m_(p_m), n_(n), t1_(n.unitOrthogonal()), t2_(n.cross(t1_)), support_m_(support_m) {}

void BendFit::add(const Vector3d& p_m, const Vector3d& n) {
  const Vector3d way = p_m - p_m_;
  const double distance_m = way.norm();
  if (distance_m >= support_m_ || distance_m == 0.0) return;  // A duplicate point gives no information.
  const double near = 1.0 - distance_m * distance_m / (support_m_ * support_m_);
  const double u1 = way.dot(t1_), u2 = way.dot(t2_), per_way = 2.0 / distance_m;
  const auto add_row = [&](const Vector3d& row, double value) {
    A_ += near * near * row * row.transpose();
    b_ += near * near * value * row;
  };
  add_row({u1, u2, 0.0}, n.dot(t1_));
  add_row({0.0, u1, u2}, n.dot(t2_));
  // On a ball the height exceeds the second order by a quarter of the squared sine.
  const double over_m = way.dot(n_) / (1.25 - 0.25 * std::pow(n.dot(n_), 2));
  add_row(per_way * Vector3d(0.5 * u1 * u1, u1 * u2, 0.5 * u2 * u2), -per_way * over_m);
}

SurfaceBend BendFit::bend() const {
  const double size = A_.trace();
  if (!(A_.determinant() > 1e-6 * size * size * size)) return {.t1 = t1_};
  const Vector3d k = A_.inverse() * b_;
  const double mean = 0.5 * (k[0] + k[2]), half = 0.5 * (k[0] - k[2]), spread = std::hypot(half, k[1]);
  const double angle = 0.5 * std::atan2(k[1], half);
  const double most = 1.0 / support_m_;  // Larger curvatures are noise, or are not resolved.
  return {std::cos(angle) * t1_ + std::sin(angle) * t2_, std::clamp(mean + spread, -most, most),
          std::clamp(mean - spread, -most, most)};
}

}  // namespace thenar
