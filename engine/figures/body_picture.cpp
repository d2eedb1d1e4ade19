// SPDX-License-Identifier: Apache-2.0
#include "engine/figures/body_picture.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <variant>

namespace thenar {

using Eigen::Isometry3d;
using Eigen::Vector3d;

namespace {

constexpr double kNear_m = 0.08, kGrid_m = 0.02, kLine_m = 0.35e-3;  // The last: half of a line's width.
const Vector3d kLine(0.35, 0.38, 0.42);

/// Draws lines in a solid's frame, in dots that touch.
struct Pen {
  const Isometry3d& X_WE;
  const Vector3d& near_m;
  const Vector3d& to_eye;
  std::vector<Surfel>& surfels;

  void dot(const Vector3d& point) const {
    const Vector3d point_W = X_WE * point;
    if ((point_W - near_m).norm() < kNear_m) surfels.push_back({point_W, to_eye, kLine, kLine_m});
  }
  void line(const Vector3d& from, const Vector3d& to) const {
    // Only what may be near: a table can have metres.
    const Vector3d way = to - from, centre = X_WE.inverse() * near_m;
    const double length_m = way.norm(), middle_m = (centre - from).dot(way) / length_m;
    const double begin_m = std::clamp(middle_m - kNear_m, 0.0, length_m);
    const double end_m = std::clamp(middle_m + kNear_m, 0.0, length_m);
    const auto steps = static_cast<int>(std::ceil((end_m - begin_m) / kLine_m));
    for (int i = 0; i <= steps; ++i) {
      dot(from + way * ((begin_m + (end_m - begin_m) * i / std::max(1, steps)) / length_m));
    }
  }
  /// About an axis of the frame.
  void circle(double radius_m, double height_m, int axis = 2) const {
    // Of what is larger, no more dots than a ring of 1 m has.
    const auto steps = static_cast<int>(2.0 * std::numbers::pi * std::min(radius_m, 1.0) / kLine_m);
    for (int i = 0; i < steps; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / steps;
      Vector3d point;
      point[axis] = height_m;
      point[(axis + 1) % 3] = radius_m * std::cos(angle);
      point[(axis + 2) % 3] = radius_m * std::sin(angle);
      dot(point);
    }
  }

  void operator()(const HalfSpace&) const {
    const Vector3d centre = X_WE.inverse() * near_m;
    for (const int axis : {0, 1}) {
      const int other = 1 - axis;
      const auto first = static_cast<int>(std::ceil((centre[other] - kNear_m) / kGrid_m));
      for (int n = first; n * kGrid_m < centre[other] + kNear_m; ++n) {
        const Vector3d from = centre[axis] * Vector3d::Unit(axis) + n * kGrid_m * Vector3d::Unit(other);
        line(from - kNear_m * Vector3d::Unit(axis), from + kNear_m * Vector3d::Unit(axis));
      }
    }
  }
  void operator()(const BoxShape& box) const {
    const Vector3d half = 0.5 * box.size_m;
    for (int i = 0; i < 8; ++i) {
      const Vector3d corner = half.cwiseProduct(Vector3d(i % 2 * 2 - 1, i / 2 % 2 * 2 - 1, i / 4 * 2 - 1));
      for (int axis = 0; axis < 3; ++axis) {
        if (corner[axis] < 0.0) line(corner, corner + box.size_m[axis] * Vector3d::Unit(axis));
      }
    }
  }
  void operator()(const SphereShape& sphere) const {
    for (const int axis : {0, 1, 2}) circle(sphere.radius_m, 0.0, axis);
  }
  void operator()(const CylinderShape& cylinder) const {
    const double half_m = 0.5 * cylinder.length_m;
    for (const double height_m : {-half_m, half_m}) circle(cylinder.radius_m, height_m);
    walls(cylinder.radius_m, -half_m, half_m);
  }
  void operator()(const HoleShape& hole) const {
    circle(hole.radius_m + hole.chamfer_m, 0.0);
    if (hole.chamfer_m > 0.0) circle(hole.radius_m, -hole.chamfer_m);
    circle(hole.radius_m, -hole.depth_m);
    walls(hole.radius_m, -hole.depth_m, -hole.chamfer_m);
  }
  void walls(double radius_m, double from_m, double to_m) const {
    constexpr int kWalls = 12;
    for (int i = 0; i < kWalls; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / kWalls;
      const Vector3d out = radius_m * Vector3d(std::cos(angle), std::sin(angle), 0.0);
      line(out + from_m * Vector3d::UnitZ(), out + to_m * Vector3d::UnitZ());
    }
  }
};

}  // namespace

void add_outline(const Solid& solid, const Isometry3d& X_WE, const Vector3d& near_m, const Vector3d& to_eye,
                 std::vector<Surfel>& surfels) {
  std::visit(Pen{X_WE, near_m, to_eye, surfels}, solid);
}

}  // namespace thenar
