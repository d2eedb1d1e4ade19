#include "engine/voronoi_cells.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numbers>
#include <vector>

namespace thenar {

using Eigen::Index;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

using Polygon = std::vector<Vector2d>;

/// Leaves of the polygon what lies at n.x <= c [Sutherland, Hodgman 1974].
void clip(const Vector2d& n, double c, Polygon& polygon, Polygon& work) {
  const auto outside = [&](const Vector2d& x) { return n.dot(x) > c; };
  if (std::none_of(polygon.begin(), polygon.end(), outside)) return;
  work.clear();
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector2d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double beyond_a = n.dot(a) - c, beyond_b = n.dot(b) - c;
    if (beyond_a <= 0.0) work.push_back(a);
    if ((beyond_a > 0.0) != (beyond_b > 0.0)) work.emplace_back(a + beyond_a / (beyond_a - beyond_b) * (b - a));
  }
  polygon.swap(work);
}

struct Patch {
  double area = 0.0;
  Vector2d centroid = Vector2d::Zero();
};

Patch patch(const Polygon& polygon) {
  Patch sum;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector2d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double triangle = 0.5 * (a.x() * b.y() - a.y() * b.x());  // with the origin
    sum.area += triangle;
    sum.centroid += triangle / 3.0 * (a + b);
  }
  sum.centroid /= sum.area;
  return sum;
}

}  // namespace

VoronoiCells voronoi_cells(const Eigen::Matrix3Xd& directions) {
  const Index n = directions.cols();
  VoronoiCells cells{Eigen::VectorXd(n), Eigen::Matrix3Xd(3, n)};
  Polygon cell, work;
  for (Index i = 0; i < n; ++i) {
    // Seen from the sphere's centre on the plane that touches it at direction i, cells have straight edges: the points
    // d_i + t with (d_i + t).(d_j - d_i) = 0.
    const Vector3d d = directions.col(i), e1 = d.unitOrthogonal(), e2 = d.cross(e1);
    // Where few directions leave a cell wider than that, its area is anyone's guess.
    cell = {{-2.0, -2.0}, {2.0, -2.0}, {2.0, 2.0}, {-2.0, 2.0}};
    for (Index j = 0; j < n; ++j) {
      const Vector3d between = directions.col(j) - d;
      if (j == i || between.squaredNorm() < 1e-20) continue;
      clip({between.dot(e1), between.dot(e2)}, -between.dot(d), cell, work);
    }
    const Patch seen = patch(cell);
    cells.areas[i] = seen.area;
    cells.centroids.col(i) = (d + seen.centroid.x() * e1 + seen.centroid.y() * e2).normalized();
  }
  // The plane's areas exceed the sphere's, by about the same share everywhere.
  cells.areas *= 4.0 * std::numbers::pi / cells.areas.sum();
  return cells;
}

}  // namespace thenar
