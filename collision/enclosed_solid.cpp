// SPDX-License-Identifier: Apache-2.0
#include "collision/enclosed_solid.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <tuple>
#include <utility>
#include <vector>

#include "collision/mesh_edges.h"

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

/// A volume, and its first moment.
struct Moments {
  double volume_m3 = 0.0;
  Vector3d first_m4 = Vector3d::Zero();
};

/// Those of the tetrahedra from the origin to all triangles: their volumes, with a sign, at a quarter of their corners'
/// sum.
Moments tetrahedra(const TriangleMesh& mesh) {
  Moments sum;
  for (const auto triangle : mesh.triangles.colwise()) {
    const Vector3d a = mesh.vertices_m.col(triangle[0]), b = mesh.vertices_m.col(triangle[1]);
    const Vector3d c = mesh.vertices_m.col(triangle[2]);
    const double volume_m3 = a.dot(b.cross(c)) / 6.0;
    sum.volume_m3 += volume_m3;
    sum.first_m4 += volume_m3 * 0.25 * (a + b + c);
  }
  return sum;
}

/// Where a line along x meets a face.
struct LineCrossing {
  std::int64_t line;
  double x_m;
  int rise;  ///< Solids that are entered there.
};

/// Lines along x, in the middles of a grid's cells across y and z.
struct Lines {
  double low_y_m, low_z_m, step_y_m, step_z_m;
  std::int64_t rows;  ///< Along y, and along z.

  [[nodiscard]] double y_m(std::int64_t i) const { return low_y_m + (static_cast<double>(i) + 0.5) * step_y_m; }
  [[nodiscard]] double z_m(std::int64_t k) const { return low_z_m + (static_cast<double>(k) + 0.5) * step_z_m; }
  /// The first row whose middle is not below; one of 0 .. rows.
  [[nodiscard]] std::int64_t row(double at_m, double low_m, double step_m) const {
    const double row = std::ceil((at_m - low_m) / step_m - 0.5);
    return static_cast<std::int64_t>(std::clamp(row, 0.0, static_cast<double>(rows)));
  }
};

/// Adds the lines that a triangle crosses. Neighbours decide alike what lies on either side of their edge, since its
/// crossing with a row is computed from its ends in one order: a line enters a closed surface as often as it leaves it.
void add_crossings(const TriangleMesh& mesh, const Eigen::Vector3i& triangle, const Lines& lines,
                   std::vector<LineCrossing>& crossings) {
  const auto corner = [&](int k) -> Vector3d { return mesh.vertices_m.col(triangle[k]); };
  const double low_m = std::min({corner(0).z(), corner(1).z(), corner(2).z()});
  const double high_m = std::max({corner(0).z(), corner(1).z(), corner(2).z()});
  const Vector3d n = Vector3d(corner(1) - corner(0)).cross(Vector3d(corner(2) - corner(0)));
  const auto [nearest, farthest] = std::minmax({corner(0).x(), corner(1).x(), corner(2).x()});
  // One row more on either side: which rows a side crosses its ends decide below.
  const std::int64_t first = std::max<std::int64_t>(0, lines.row(low_m, lines.low_z_m, lines.step_z_m) - 1);
  const std::int64_t last = std::min(lines.rows, lines.row(high_m, lines.low_z_m, lines.step_z_m) + 1);
  for (std::int64_t k = first; k < last; ++k) {
    const double z_m = lines.z_m(k);
    double left_m = 0.0, right_m = 0.0;
    int sides = 0, left_climbs = 0;
    for (int side = 0; side < 3; ++side) {
      const int from = triangle[side], to = triangle[(side + 1) % 3];
      const Vector3d a = mesh.vertices_m.col(std::min(from, to)), b = mesh.vertices_m.col(std::max(from, to));
      if ((a.z() <= z_m) == (b.z() <= z_m)) continue;
      const double y_m = a.y() + (b.y() - a.y()) * ((z_m - a.z()) / (b.z() - a.z()));
      const int climbs = mesh.vertices_m(2, from) <= z_m ? 1 : -1;
      if (sides == 0 || y_m < left_m) {
        if (sides > 0) right_m = left_m;
        left_m = y_m;
        left_climbs = climbs;
      } else {
        right_m = y_m;
      }
      ++sides;
    }
    if (sides != 2) continue;
    // Seen against x, a triangle with its left side falling is wound counter-clockwise: its outside is at larger x.
    const std::int64_t begin = lines.row(left_m, lines.low_y_m, lines.step_y_m);
    const std::int64_t end = lines.row(right_m, lines.low_y_m, lines.step_y_m);
    for (std::int64_t i = begin; i < end; ++i) {
      // In the plane of the triangle; of one along x anywhere in it.
      const double off_m = n.y() * (lines.y_m(i) - corner(0).y()) + n.z() * (z_m - corner(0).z());
      const double x_m = n.x() == 0.0 ? nearest : corner(0).x() - off_m / n.x();
      crossings.push_back({k * lines.rows + i, std::clamp(x_m, nearest, farthest), left_climbs});
    }
  }
}

/// As many lines as the time allows: each crosses the sum of the faces' shadows over that of the box.
Lines lines_across(const TriangleMesh& mesh, const Eigen::AlignedBox3d& box) {
  double shadow_m2 = 0.0;
  for (const auto t : mesh.triangles.colwise()) {
    const Vector3d a = mesh.vertices_m.col(t[0]), b = mesh.vertices_m.col(t[1]), c = mesh.vertices_m.col(t[2]);
    shadow_m2 += 0.5 * std::abs((b - a).cross(c - a).x());
  }
  const Vector3d size_m = box.sizes();
  const double each = std::max(1.0, shadow_m2 / std::max(size_m.y() * size_m.z(), 1e-300));
  const double most = 5e5 + 4.0 * static_cast<double>(mesh.triangles.cols());
  const auto rows = static_cast<std::int64_t>(std::clamp(std::sqrt(most / each), 8.0, 1000.0));
  const double count = static_cast<double>(rows);
  return {box.min().y(), box.min().z(), size_m.y() / count, size_m.z() / count, rows};
}

/// What tetrahedra count too often: parts of lines in several solids, and less than never, in what is inside out.
Moments counted_again(const TriangleMesh& mesh, const Eigen::AlignedBox3d& box) {
  const Lines lines = lines_across(mesh, box);
  std::vector<LineCrossing> crossings;
  for (const auto triangle : mesh.triangles.colwise()) add_crossings(mesh, triangle, lines, crossings);
  std::ranges::sort(crossings, {}, [](const LineCrossing& c) { return std::tuple(c.line, c.x_m, -c.rise); });
  Moments again;
  const double cell_m2 = lines.step_y_m * lines.step_z_m;
  int solids = 0;
  for (std::size_t i = 0; i + 1 < crossings.size(); ++i) {
    const LineCrossing &from = crossings[i], &to = crossings[i + 1];
    solids += from.rise;
    if (from.line != to.line) solids = 0;
    const int more = solids - (solids > 0 ? 1 : 0);
    if (more == 0) continue;
    const double volume_m3 = more * (to.x_m - from.x_m) * cell_m2;
    again.volume_m3 += volume_m3;
    again.first_m4 += volume_m3 * Vector3d(0.5 * (from.x_m + to.x_m), lines.y_m(from.line % lines.rows),
                                           lines.z_m(from.line / lines.rows));
  }
  return again;
}

}  // namespace

EnclosedSolid enclosed_solid(const TriangleMesh& mesh) {
  TriangleMesh closed = mesh;
  Eigen::AlignedBox3d box;
  for (const int vertex : mesh.triangles.reshaped()) box.extend(mesh.vertices_m.col(vertex));
  if (box.isEmpty()) return {};
  // About the middle, so that the sums do not depend on where the mesh is.
  const Vector3d middle_m = box.center();
  closed.vertices_m.colwise() -= middle_m;
  box.translate(-middle_m);
  const std::vector<MeshRim> rims = close_rims(closed);
  Moments moments = tetrahedra(closed);
  if (has_several_parts(mesh)) {
    const Moments again = counted_again(closed, box);
    moments.volume_m3 -= again.volume_m3;
    moments.first_m4 -= again.first_m4;
  }
  EnclosedSolid solid{moments.volume_m3, middle_m, 0.0};
  if (!(solid.volume_m3 > 0.0)) return solid;
  const Vector3d centroid_m = moments.first_m4 / moments.volume_m3;
  for (const MeshRim& rim : rims) {
    const double radius_m = std::sqrt(rim.area_m2 / std::numbers::pi);
    const double bulge_m3 = 2.0 / 3.0 * rim.area_m2 * radius_m;
    solid.error_m += bulge_m3 * (rim.middle_m - centroid_m).norm() / solid.volume_m3;
  }
  solid.centroid_m += centroid_m;
  return solid;
}

}  // namespace thenar
