// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/foxglove_solid.h"

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace thenar::foxglove {

namespace {

constexpr int kAround = 48;            // Corners of a circle.
constexpr double kPlane_m = 0.12;      // Radius of the shown part of a plane.
constexpr double kPlateWall_m = 0.03;  // Width of the shown plate around a hole.

/// Radius and height of the profile of a surface of revolution about z.
using Section = std::vector<std::pair<double, double>>;

Json turned(const Section& section, const Color& color) {
  Eigen::Matrix3Xd points_m(3, kAround * std::ssize(section));
  std::vector<int> indices;
  for (int i = 0; i < std::ssize(section); ++i) {
    const auto& [radius_m, z_m] = section[static_cast<std::size_t>(i)];
    for (int j = 0; j < kAround; ++j) {
      const double angle = 2.0 * std::numbers::pi * j / kAround;
      points_m.col(kAround * i + j) << radius_m * std::cos(angle), radius_m * std::sin(angle), z_m;
      if (i == 0) continue;
      const int here = kAround * i + j, next = kAround * i + (j + 1) % kAround;
      for (const int corner : {here - kAround, next - kAround, next, here - kAround, next, here})
        indices.push_back(corner);
    }
  }
  return triangles(points_m, indices, color);
}

struct Drawn {
  const Color& color;

  Json operator()(const HalfSpace&) const { return turned({{0.0, 0.0}, {kPlane_m, 0.0}}, color); }
  Json operator()(const BoxShape& box) const {
    Eigen::Matrix3Xd corners_m(3, 8);
    for (int i = 0; i < 8; ++i) {
      const Eigen::Vector3d side(i & 1 ? 0.5 : -0.5, i & 2 ? 0.5 : -0.5, i & 4 ? 0.5 : -0.5);
      corners_m.col(i) = side.cwiseProduct(box.size_m);
    }
    std::vector<int> indices;
    for (const int axis : {1, 2, 4}) {
      const int u = axis == 4 ? 1 : 2 * axis, v = 7 - axis - u;
      for (const int face : {0, axis}) {
        for (const int corner : {0, u, u + v, 0, u + v, v}) indices.push_back(face + corner);
      }
    }
    return triangles(corners_m, indices, color);
  }
  Json operator()(const SphereShape& sphere) const {
    Section section;
    for (int i = 0; i <= kAround / 2; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / kAround;
      section.emplace_back(sphere.radius_m * std::sin(angle), -sphere.radius_m * std::cos(angle));
    }
    return turned(section, color);
  }
  Json operator()(const CylinderShape& cylinder) const {
    const double r = cylinder.radius_m, half_m = 0.5 * cylinder.length_m;
    return turned({{0.0, -half_m}, {r, -half_m}, {r, half_m}, {0.0, half_m}}, color);
  }
  Json operator()(const HoleShape& hole) const {
    const double r = hole.radius_m, mouth_m = r + hole.chamfer_m;
    return turned(
        {{0.0, -hole.depth_m}, {r, -hole.depth_m}, {r, -hole.chamfer_m}, {mouth_m, 0.0}, {mouth_m + kPlateWall_m, 0.0}},
        color);
  }
};

}  // namespace

Json solid(const Solid& solid, const Color& color) { return std::visit(Drawn{color}, solid); }

}  // namespace thenar::foxglove
