// SPDX-License-Identifier: Apache-2.0
#include "engine/imports/wrapping.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace thenar {

using Eigen::Matrix;
using Eigen::Rotation2Dd;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

constexpr double kTiny = 1e-12;
using TwoPoints = std::array<Vector2d, 2>;

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Returns the point of the segment nearest to the origin.
Vector2d nearest_to_origin(const Vector2d& a, const Vector2d& b) {
  const Vector2d along = b - a;
  const double t = along.squaredNorm() > kTiny * kTiny ? -along.dot(a) / along.squaredNorm() : 0.0;
  return a + std::clamp(t, 0.0, 1.0) * along;
}

bool cross_each_other(const Vector2d& a, const Vector2d& b, const Vector2d& c, const Vector2d& d) {
  const double determinant = cross(b - a, d - c);
  if (std::abs(determinant) < kTiny * kTiny) return false;
  const double t = cross(c - a, d - c) / determinant, s = cross(c - a, b - a) / determinant;
  return t >= 0.0 && t <= 1.0 && s >= 0.0 && s <= 1.0;
}

/// Returns tangent points of the strings from a and b to a circle about the origin that run around it with the turn (1
/// counterclockwise, -1 clockwise).
TwoPoints tangents(const Vector2d& a, const Vector2d& b, double radius, double turn) {
  const double from_a = std::acos(radius / a.norm()), from_b = std::acos(radius / b.norm());
  return {radius * (Rotation2Dd(turn * from_a) * a.normalized()),
          radius * (Rotation2Dd(-turn * from_b) * b.normalized())};
}

/// Finds the string around the outside of a circle.
std::optional<TwoPoints> around(const Vector2d& a, const Vector2d& b, double radius,
                                const std::optional<Vector2d>& side) {
  const Vector2d nearest = nearest_to_origin(a, b);
  if (nearest.norm() > radius && (!side || side->dot(nearest) >= 0.0)) return std::nullopt;
  std::optional<TwoPoints> best;
  double most = 0.0;
  for (const double turn : {1.0, -1.0}) {
    const TwoPoints ends = tangents(a, b, radius, turn);
    // Where the free parts cross, the string would have to turn back on the circle.
    if (cross_each_other(a, ends[0], b, ends[1])) continue;
    const Vector2d middle = ends[0] + ends[1];
    const double merit = side ? side->dot(middle) / std::max(middle.norm(), kTiny) : -(ends[0] - ends[1]).norm();
    if (best && merit <= most) continue;
    best = ends;
    most = merit;
  }
  return best;
}

/// Finds the string through a ring: it touches the circle from inside, at the point of the shortest path.
std::optional<TwoPoints> through(const Vector2d& a, const Vector2d& b, double radius) {
  if (nearest_to_origin(a, b).norm() <= radius) return std::nullopt;
  const double turn = std::atan2(cross(a, b), a.dot(b));  // From the direction of a to that of b, the smaller angle.
  const auto point = [&](double share) { return Vector2d(radius * (Rotation2Dd(share * turn) * a.normalized())); };
  // Change of length with the share of the turn: negative at a's direction, positive at b's.
  const auto slope = [&](double share) {
    const Vector2d p = point(share), tangent = turn * Vector2d(-p.y(), p.x());
    return tangent.dot((p - a).normalized() + (p - b).normalized());
  };
  double low = 0.0, high = 1.0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (slope(middle) < 0.0 ? low : high) = middle;
  }
  return TwoPoints{point(low), point(low)};
}

std::optional<TwoPoints> in_plane(const Vector2d& a, const Vector2d& b, double radius,
                                  const std::optional<Vector2d>& side, bool inside) {
  if (a.norm() <= radius || b.norm() <= radius || radius < kTiny) return std::nullopt;
  return inside ? through(a, b, radius) : around(a, b, radius, side);
}

}  // namespace

std::optional<std::array<Vector3d, 2>> wrap(const WrapSurface& surface, const Vector3d& a, const Vector3d& b,
                                            const std::optional<Vector3d>& side) {
  // For a sphere the plane through its centre and both ends, for a cylinder the one across it.
  Matrix<double, 3, 2> axes = Matrix<double, 3, 2>::Identity();
  if (!surface.is_cylinder) {
    if (a.norm() <= kTiny) return std::nullopt;
    axes.col(0) = a.normalized();
    const Vector3d across = b - b.dot(axes.col(0)) * axes.col(0);
    axes.col(1) = across.norm() > kTiny ? across.normalized() : a.unitOrthogonal();
  }
  std::optional<Vector2d> side_2;
  if (side) side_2 = axes.transpose() * *side;
  const bool inside = side_2 && side_2->norm() < surface.radius_m;
  const Vector2d a_2 = axes.transpose() * a, b_2 = axes.transpose() * b;
  const std::optional<TwoPoints> ends = in_plane(a_2, b_2, surface.radius_m, side_2, inside);
  if (!ends) return std::nullopt;
  std::array<Vector3d, 2> points{axes * (*ends)[0], axes * (*ends)[1]};
  if (!surface.is_cylinder) return points;
  // Unrolled, the string is straight: it rises in proportion to its length.
  const double angle = std::abs(std::atan2(cross((*ends)[0], (*ends)[1]), (*ends)[0].dot((*ends)[1])));
  const double first = (a_2 - (*ends)[0]).norm(), last = (b_2 - (*ends)[1]).norm();
  const double free_turn =
      cross(a_2, (*ends)[0]);  // The sign of the turn: the string runs ahead of a around the circle.
  const bool long_way = !inside && cross((*ends)[0], (*ends)[1]) * free_turn < 0.0;
  const double arc = surface.radius_m * (long_way ? 2.0 * std::numbers::pi - angle : angle);
  const double length = std::max(first + arc + last, kTiny);
  points[0].z() = a.z() + (b.z() - a.z()) * first / length;
  points[1].z() = a.z() + (b.z() - a.z()) * (first + arc) / length;
  return points;
}

}  // namespace thenar
