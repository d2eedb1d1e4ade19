// SPDX-License-Identifier: Apache-2.0
#include "collision/surface_cells.h"

#include <Eigen/Geometry>
#include <cmath>

#include "collision/polygon.h"

namespace thenar {

using Eigen::Index;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

double flat_m2(const Vector3d& a, const Vector3d& b, const Vector3d& c) { return 0.5 * (b - a).cross(c - a).norm(); }

/// Computes the area of the surface over a triangle with its corners on it: of one flat triangle and of four,
/// extrapolated [Richardson], for both err by the square of their size.
double curved_m2(const Vector3d& a, const Vector3d& b, const Vector3d& c, const OntoSurface& onto) {
  const Vector3d ab = onto(0.5 * (a + b)), bc = onto(0.5 * (b + c)), ca = onto(0.5 * (c + a));
  const double four = flat_m2(a, ab, ca) + flat_m2(ab, b, bc) + flat_m2(ca, bc, c) + flat_m2(ab, bc, ca);
  return (4.0 * four - flat_m2(a, b, c)) / 3.0;
}

}  // namespace

SurfaceCells surface_cells(const Eigen::Matrix3Xd& points_m, const Eigen::Matrix3Xd& normals, const OntoSurface& onto,
                           double whole_m2) {
  const Index n = points_m.cols();
  SurfaceCells cells{Eigen::VectorXd(n), Eigen::Matrix3Xd(3, n)};
  // Where few points leave a cell wider than that, its area is anyone's guess.
  const double widest_m = 2.0 * std::sqrt(whole_m2 / 12.0);
  Polygon cell, work;
  for (Index i = 0; i < n; ++i) {
    // On the plane that touches the surface at point i, the part nearer to i than to j is bounded by a line.
    const Vector3d p = points_m.col(i), e1 = normals.col(i).unitOrthogonal(), e2 = normals.col(i).cross(e1);
    cell = {{-widest_m, -widest_m}, {widest_m, -widest_m}, {widest_m, widest_m}, {-widest_m, widest_m}};
    double cell_reach2 = reach2(cell);
    for (Index k = 1; k < n; ++k) {
      const Vector3d between = points_m.col((i + k) % n) - p;
      const Vector2d across(between.dot(e1), between.dot(e2));
      const double squared = between.squaredNorm(), c = 0.5 * squared;
      if (c * c >= across.squaredNorm() * cell_reach2 || squared < 1e-20 * whole_m2) continue;
      clip(across, c, cell, work);
      cell_reach2 = reach2(cell);
    }
    const PolygonArea flat = area_of(cell);
    cells.centroids_m.col(i) = p + flat.centroid.x() * e1 + flat.centroid.y() * e2;
    cells.areas_m2[i] = onto ? 0.0 : flat.area;
    if (!onto) continue;
    const auto corner = [&](std::size_t k) -> Vector3d {
      const Vector2d& x = cell[k % cell.size()];
      return onto(p + x.x() * e1 + x.y() * e2);
    };
    for (std::size_t k = 0; k < cell.size(); ++k) {
      cells.areas_m2[i] += curved_m2(p, corner(k), corner(k + 1), onto);
    }
  }
  cells.areas_m2 *= whole_m2 / cells.areas_m2.sum();
  return cells;
}

}  // namespace thenar
