// SPDX-License-Identifier: Apache-2.0
#include "collision/cell_cover.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace thenar {

using Eigen::Vector2d;

namespace {

// A disc, as a polygon of the same area, and a bound of the ratio of their radii.
constexpr int kCorners = 16;
constexpr double kCorner = 1.02;
// A face at less than this angle (a sine) to N counts as parallel.
constexpr double kAlong = 1e-9;
// Other faces than the cell's own count from two radii of the cell on, fully from one radius on: there they cover a
// fifth of the disc of two radii.
constexpr double kAround = 2.0, kCut = 0.1955;
// No point of a pulp that is pressed on a single face is at a smaller cosine to it.
constexpr double kTurned = 0.6;
// Faces deeper than this, in radii of the cell, are ignored.
constexpr double kPassed = 6.0;

void set_to_disc(double area_m2, Polygon& cell) {
  static const auto corners = [] {
    std::array<Vector2d, kCorners> on_circle;
    const double angle = 2.0 * std::numbers::pi / kCorners, unit = std::sqrt(2.0 / (kCorners * std::sin(angle)));
    for (int k = 0; k < kCorners; ++k) on_circle[k] = unit * Vector2d(std::cos(k * angle), std::sin(k * angle));
    return on_circle;
  }();
  const double root_m = std::sqrt(area_m2);
  cell.clear();
  for (const Vector2d& corner : corners) cell.push_back(root_m * corner);
}

/// Clips a polygon to where a face is no deeper than another one.
void clip_to(const CellFace& face, const CellFace& other, Polygon& polygon, Polygon& scratch) {
  clip(face.facing * other.slope - other.facing * face.slope,
       face.height_m * other.facing - other.height_m * face.facing, polygon, scratch);
}

double depth_m(const CellFace& face, const Vector2d& y) { return -(face.height_m + face.slope.dot(y)) / face.facing; }

/// Computes integrals over a polygon of the first three powers of a depth that is linear over it [m^3, m^4, m^5].
Eigen::Vector3d integrals(const CellFace& face, const Polygon& polygon) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  const double a = depth_m(face, polygon[0]);
  for (std::size_t i = 1; i + 1 < polygon.size(); ++i) {
    const Vector2d to_b = polygon[i] - polygon[0], to_c = polygon[i + 1] - polygon[0];
    const double area = 0.5 * (to_b.x() * to_c.y() - to_b.y() * to_c.x());
    const double b = depth_m(face, polygon[i]), c = depth_m(face, polygon[i + 1]);
    const double ab = a + b, second = a * ab + b * b;
    sum += area * Eigen::Vector3d((ab + c) / 3.0, (second + c * (ab + c)) / 6.0,
                                  (a * second + b * b * b + c * (second + c * (ab + c))) / 10.0);
  }
  return sum;
}

double rise(double x) {
  const double t = std::clamp(x, 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

bool faces_cell(const CellFace& face) { return face.facing > kAlong; }

/// Calls take(n, c) for the half planes n.y <= c that remain of a cell beside faces that N does not point at.
template <typename Take>
void for_each_side(std::span<const CellFace> faces, const Take& take) {
  for (const CellFace& side : faces) {
    if (faces_cell(side)) continue;
    if (side.facing > -kAlong) {
      take(side.slope, -side.height_m);
      continue;
    }
    // N leaves the solid there: not before it entered.
    for (const CellFace& face : faces) {
      if (!faces_cell(face)) continue;
      take(face.facing * side.slope - side.facing * face.slope,
           side.facing * face.height_m - face.facing * side.height_m);
    }
  }
}

bool leave_nothing(std::span<const CellFace> faces, double radius_m) {
  bool nothing = false;
  for_each_side(faces, [&](const Vector2d& n, double c) { nothing = nothing || c < -radius_m * n.norm(); });
  return nothing;
}

void clip_to_sides(std::span<const CellFace> faces, double radius_m, Polygon& cell, Polygon& scratch) {
  for_each_side(faces, [&](const Vector2d& n, double c) {
    if (c < radius_m * n.norm()) clip(n, c, cell, scratch);
  });
}

}  // namespace

CellWork::CellWork(std::size_t faces) {
  // Each cut adds a corner at most; sides are cut by each of the faces.
  for (Polygon* polygon : {&around, &cell, &part, &scratch}) polygon->reserve(kCorners + (faces + 2) * (faces + 2));
}

CellCover cell_cover(std::span<const CellFace> faces, double area_m2, CellWork& work) {
  const double around_m2 = kAround * kAround * area_m2, radius_m = std::sqrt(area_m2 / std::numbers::pi),
               passed_m = kPassed * radius_m, corner_m = kCorner * radius_m;
  if (leave_nothing(faces, corner_m)) return {.depth_m = -std::numeric_limits<double>::infinity()};
  set_to_disc(around_m2, work.around);
  clip_to_sides(faces, kAround * corner_m, work.around, work.scratch);
  set_to_disc(area_m2, work.cell);
  clip_to_sides(faces, corner_m, work.cell, work.scratch);

  const CellFace* main = nullptr;
  double main_m2 = 0.0, deep_m2 = 0.0, highest_m = -std::numeric_limits<double>::infinity();
  Eigen::Vector3d powers = Eigen::Vector3d::Zero();
  Vector2d moment_m3 = Vector2d::Zero();
  for (const CellFace& face : faces) {
    if (!faces_cell(face)) continue;
    const auto take_part = [&](const Polygon& of) {
      work.part = of;
      for (const CellFace& other : faces) {
        if (&other != &face && faces_cell(other)) clip_to(face, other, work.part, work.scratch);
      }
    };
    take_part(work.around);
    clip(face.slope, passed_m * face.facing - face.height_m, work.part, work.scratch);
    if (work.part.size() >= 3) {
      const double own_m2 = area_of(work.part).area;
      if (!main || own_m2 > main_m2) {
        main = &face;
        main_m2 = own_m2;
      }
    }
    take_part(work.cell);
    for (const Vector2d& y : work.part) highest_m = std::max(highest_m, depth_m(face, y));
    clip(face.slope, -face.height_m, work.part, work.scratch);
    if (work.part.size() < 3) continue;
    const PolygonArea deep = area_of(work.part);
    if (!(deep.area > 0.0)) continue;
    deep_m2 += deep.area;
    moment_m3 += deep.area * deep.centroid;
    powers += integrals(face, work.part);
  }

  CellCover cover{.depth_m = std::min(highest_m, 0.0)};
  if (powers[1] > 0.0) {
    cover.depth_m = 0.5 * (powers[1] / powers[0] + powers[2] / powers[1]);
    cover.share = std::min(1.0, deep_m2 / area_m2);
    cover.middle_m = moment_m3 / deep_m2;
  }
  if (!main) return cover;
  constexpr double kRounding = 1e-9;
  const double alone = 1.0 - rise((1.0 - main_m2 / around_m2 - kRounding) / kCut);
  const double counts = 1.0 - alone * rise((main->facing - kSteep) / (kTurned - kSteep));
  cover.main = static_cast<std::size_t>(main - faces.data());
  cover.own = 1.0 - counts;
  if (counts == 1.0) return cover;
  cover.depth_m = counts * cover.depth_m + (1.0 - counts) * (depth_m(*main, Vector2d::Zero()) + main->own_m);
  cover.share = 1.0 - counts * (1.0 - cover.share);
  cover.middle_m *= counts;
  return cover;
}

}  // namespace thenar
