// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <vector>

#include "thenar/eigen_layout.h"

namespace thenar {

/// A convex polygon, its corners counter-clockwise.
using Polygon = std::vector<Eigen::Vector2d>;

/// Clips the polygon to n.x <= c [Sutherland, Hodgman 1974].
inline void clip(const Eigen::Vector2d& n, double c, Polygon& polygon, Polygon& work) {
  work.clear();
  if (polygon.empty()) return;
  double beyond_a = n.dot(polygon.front()) - c;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d &a = polygon[i], &b = i + 1 < polygon.size() ? polygon[i + 1] : polygon.front();
    const double beyond_b = n.dot(b) - c;
    if (beyond_a <= 0.0) work.push_back(a);
    if ((beyond_a > 0.0) != (beyond_b > 0.0)) work.emplace_back(a + beyond_a / (beyond_a - beyond_b) * (b - a));
    beyond_a = beyond_b;
  }
  polygon.swap(work);
}

/// Returns the squared distance of the polygon's farthest corner from the origin.
inline double reach2(const Polygon& polygon) {
  double most = 0.0;
  for (const Eigen::Vector2d& x : polygon) most = std::max(most, x.squaredNorm());
  return most;
}

/// The area and centroid of a polygon around the origin.
struct PolygonArea {
  double area = 0.0;
  Eigen::Vector2d centroid = Eigen::Vector2d::Zero();
};

inline PolygonArea area_of(const Polygon& polygon) {
  PolygonArea sum;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d &a = polygon[i], &b = i + 1 < polygon.size() ? polygon[i + 1] : polygon.front();
    const double triangle = 0.5 * (a.x() * b.y() - a.y() * b.x());  // with the origin
    sum.area += triangle;
    sum.centroid += triangle / 3.0 * (a + b);
  }
  sum.centroid /= sum.area;
  return sum;
}

}  // namespace thenar
