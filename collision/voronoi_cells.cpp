// SPDX-License-Identifier: Apache-2.0
#include "collision/voronoi_cells.h"

#include <Eigen/Geometry>
#include <numbers>

#include "collision/polygon.h"

namespace thenar {

using Eigen::Index;
using Eigen::Vector2d;
using Eigen::Vector3d;

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
    double cell_reach2 = reach2(cell);
    for (Index k = 1; k < n; ++k) {
      // From i on: in a tree's order neighbours come early, and most others are then out of reach.
      const Vector3d between = directions.col((i + k) % n) - d;
      const Vector2d across(between.dot(e1), between.dot(e2));
      const double c = -between.dot(d);
      if (c * c >= across.squaredNorm() * cell_reach2 || between.squaredNorm() < 1e-20) continue;
      clip(across, c, cell, work);
      cell_reach2 = reach2(cell);
    }
    const PolygonArea seen = area_of(cell);
    cells.areas[i] = seen.area;
    cells.centroids.col(i) = (d + seen.centroid.x() * e1 + seen.centroid.y() * e2).normalized();
  }
  // The plane's areas exceed the sphere's, by about the same share everywhere.
  cells.areas *= 4.0 * std::numbers::pi / cells.areas.sum();
  return cells;
}

}  // namespace thenar
