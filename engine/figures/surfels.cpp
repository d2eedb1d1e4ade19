// SPDX-License-Identifier: Apache-2.0
#include "engine/figures/surfels.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "collision/shapes.h"

namespace thenar {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

void add_rod(const Vector3d& from_m, const Vector3d& to_m, double radius_m, std::vector<Surfel>& surfels) {
  const Vector3d axis = (to_m - from_m).stableNormalized(), side = axis.unitOrthogonal();
  const int rings = static_cast<int>((to_m - from_m).norm() / 0.5e-3), sides = 36;
  for (int i = 0; i < rings; ++i) {
    for (int j = 0; j < sides; ++j) {
      const double angle = 2.0 * std::numbers::pi * (j + 0.5 * (i % 2)) / sides;
      const Vector3d normal = std::cos(angle) * side + std::sin(angle) * axis.cross(side);
      surfels.push_back({from_m + (to_m - from_m) * i / rings + radius_m * normal, normal, kBone, 0.6e-3});
    }
  }
}

}  // namespace

void add_ball(const Vector3d& centre_m, double radius_m, const Vector3d& color, std::vector<Surfel>& surfels) {
  static const PointCloud kUnitSphere = sample_sphere(1.0, 1500);
  for (Index i = 0; i < kUnitSphere.points_m.cols(); ++i) {
    const Vector3d normal = kUnitSphere.normals.col(i);
    surfels.push_back({centre_m + radius_m * normal, normal, color, 0.09 * radius_m});
  }
}

void add_rigid_pulp(const Fingertip& tip, const Eigen::Isometry3d& X_WF, std::vector<Surfel>& surfels) {
  if (!tip.shape) {
    add_ball(X_WF * tip.centre_m, tip.radius_m, kSkin, surfels);
    return;
  }
  constexpr double kPoints = 1500.0;
  const PointCloud cloud = sample_pulp(*tip.shape, static_cast<Index>(kPoints));
  // As large for its points as those of a ball.
  const double disc_m = 0.09 * std::sqrt(area_m2(*tip.shape) / (4.0 * std::numbers::pi));
  for (Index i = 0; i < cloud.points_m.cols(); ++i) {
    const Vector3d point_m = X_WF * (tip.centre_m + cloud.points_m.col(i));
    surfels.push_back({point_m, X_WF.linear() * cloud.normals.col(i), kSkin, disc_m});
  }
}

void add_bones(const Hand& hand, const HandPose& pose, std::vector<Surfel>& surfels) {
  for (std::size_t s = 0; s < hand.segments.size(); ++s) {
    const Segment& segment = hand.segments[s];
    if (segment.joints == 0) continue;
    const double radius_m = 0.5 * hand.fingertips[segment.finger].radius_m;
    const Vector3d joint = pose.segments[s].translation();
    add_rod(joint, pose.segments[s] * Vector3d(segment.length_m, 0.0, 0.0), radius_m, surfels);
    add_ball(joint, 1.25 * radius_m, kBone, surfels);
  }
  if (hand.slides) return;  // which begin at no wrist
  for (int k = 0; k < hand.fingers(); ++k) {
    const double radius_m = 0.5 * hand.fingertips[k].radius_m;
    add_rod(Vector3d::Zero(), pose.origin_m[hand.fingertips[k].first_joint], radius_m, surfels);
    add_ball(Vector3d::Zero(), 1.5 * radius_m, kBone, surfels);
  }
}

std::string painted(std::vector<Surfel> surfels, const Matrix3d& view) {
  std::erase_if(surfels, [&](const Surfel& s) { return view.row(2).dot(s.normal) <= 0.0; });
  std::stable_sort(surfels.begin(), surfels.end(), [&](const Surfel& a, const Surfel& b) {
    return view.row(2).dot(a.point_m) < view.row(2).dot(b.point_m);
  });
  const Vector3d light = view.transpose() * Vector3d(-0.4, 0.7, 0.6).normalized();
  std::string lines;
  for (const Surfel& s : surfels) {
    const Vector3d p = 1e3 * view * s.point_m;
    const Vector3d rgb = 255.0 * (0.55 + 0.45 * std::max(0.0, light.dot(s.normal))) * s.color;
    const int color = (static_cast<int>(rgb[0]) << 16) + (static_cast<int>(rgb[1]) << 8) + static_cast<int>(rgb[2]);
    lines += fmt::format("{:.3f} {:.3f} {:.3f} {}\n", p.x(), p.y(), 1e3 * s.radius_m, color);
  }
  return lines;
}

}  // namespace thenar
