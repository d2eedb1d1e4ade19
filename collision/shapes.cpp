// SPDX-License-Identifier: Apache-2.0
#include "collision/shapes.h"

#include <Eigen/Geometry>
#include <cmath>
#include <initializer_list>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "collision/blue_noise.h"

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using std::numbers::pi;

void require_lengths(std::initializer_list<double> lengths_m) {
  for (const double length_m : lengths_m) {
    if (length_m > 0.0 && std::isfinite(length_m)) continue;
    throw std::invalid_argument("the lengths of a shape must be finite and greater than zero");
  }
}

/// Draws a sample of the disc between two radii at height z, whose normal is along z.
SurfaceSample draw_ring(double inner_m, double outer_m, double z_m, double normal_z, Uniform& uniform) {
  const double r = std::sqrt(inner_m * inner_m + (outer_m * outer_m - inner_m * inner_m) * uniform());
  const double angle = 2.0 * pi * uniform();
  return {Vector3d(r * std::cos(angle), r * std::sin(angle), z_m), normal_z * Vector3d::UnitZ()};
}

/// Draws a sample of a cylinder's side between two heights. side: 1 if the solid is within, -1 if it is without.
SurfaceSample draw_wall(double radius_m, double low_m, double high_m, double side, Uniform& uniform) {
  const double angle = 2.0 * pi * uniform();
  const Vector3d radial = Vector3d(std::cos(angle), std::sin(angle), 0.0).normalized();
  return {radius_m * radial + (low_m + (high_m - low_m) * uniform()) * Vector3d::UnitZ(), side * radial};
}

double ring_area_m2(double inner_m, double outer_m) { return pi * (outer_m * outer_m - inner_m * inner_m); }

double wall_area_m2(double radius_m, double height_m) { return 2.0 * pi * radius_m * height_m; }

/// Draws a sample of the whole torus of a mug's handle.
SurfaceSample draw_torus(const Mug& mug, Uniform& uniform) {
  const double R = mug.handle->radius_m, r = 0.5 * mug.handle->thickness_m;
  const double along = 2.0 * pi * uniform();
  double around = 0.0;
  // The outer side of a ring is longer than the inner one.
  do {
    around = 2.0 * pi * uniform();
  } while ((R + r) * uniform() > R + r * std::cos(around));
  const Vector3d out = Vector3d(std::cos(along), 0.0, std::sin(along)).normalized();
  const Vector3d normal = (std::cos(around) * out + std::sin(around) * Vector3d::UnitY()).normalized();
  return {mug.radius_m * Vector3d::UnitX() + R * out + r * normal, normal};
}

bool is_inside_handle(const Mug& mug, const Vector3d& p_m) {
  if (!mug.handle) return false;
  const double to_circle_m = std::hypot(p_m.x() - mug.radius_m, p_m.z()) - mug.handle->radius_m;
  return std::hypot(to_circle_m, p_m.y()) < 0.5 * mug.handle->thickness_m;
}

/// A volume [m^3] and its first moment along x [m^4].
struct VolumeMoment {
  double volume_m3 = 0.0, moment_m4 = 0.0;
};

/// Integrates the handle of a mug: the part of its torus outside of the cylinder. It is cut across y into slices: the
/// ring between two circles around (radius, 0, 0), where it is beyond the wall's x.
VolumeMoment handle_volume(const Mug& mug) {
  const double R = mug.radius_m, a = mug.handle->radius_m, b = 0.5 * mug.handle->thickness_m;
  VolumeMoment handle;
  // With y = b sin(phi) the integrand is analytic and has the period pi: the midpoint rule converges like a power of n.
  constexpr int kSlices = 256;
  for (int i = 0; i < kSlices; ++i) {
    const double phi = pi * ((i + 0.5) / kSlices - 0.5);
    const double y = b * std::sin(phi), half_width = b * std::cos(phi);
    const double wall = std::sqrt(R * R - y * y) - R;  // From the ring's centre; both circles reach beyond it.
    const double thickness = pi / kSlices * half_width;
    for (const double side : {1.0, -1.0}) {
      const double r = a + side * half_width;  // A disc of radius r beyond x = wall, less that of the hole.
      const double half_chord = std::sqrt(r * r - wall * wall);
      const double area = r * r * std::acos(wall / r) - wall * half_chord;
      handle.volume_m3 += side * thickness * area;
      handle.moment_m4 += side * thickness * (R * area + 2.0 / 3.0 * half_chord * half_chord * half_chord);
    }
  }
  return handle;
}

/// Returns the sample of a superquadric in direction d from its centre. The half sizes are 1.
SurfaceSample on_unit_superquadric(const Exponents& e, const Vector3d& d) {
  const double e1 = e.north_south, e2 = e.east_west;
  // f(d) = g + h with g = (|x|^(2/e2) + |y|^(2/e2))^(e2/e1) and h = |z|^(2/e1). Taken relative to the larger of |x|
  // and |y|, no power of a small number underflows to 0/0.
  const double m = std::max(std::abs(d.x()), std::abs(d.y()));
  const Vector3d a(m > 0.0 ? std::abs(d.x()) / m : 0.0, m > 0.0 ? std::abs(d.y()) / m : 1.0, std::abs(d.z()));
  const double q = std::pow(a.x(), 2.0 / e2) + std::pow(a.y(), 2.0 / e2);
  const double f = std::pow(m, 2.0 / e1) * std::pow(q, e2 / e1) + std::pow(a.z(), 2.0 / e1);
  const double equator = std::pow(m, 2.0 / e1 - 1.0) * std::pow(q, e2 / e1 - 1.0);
  const Vector3d gradient(std::copysign(equator * std::pow(a.x(), 2.0 / e2 - 1.0), d.x()),
                          std::copysign(equator * std::pow(a.y(), 2.0 / e2 - 1.0), d.y()),
                          std::copysign(std::pow(a.z(), 2.0 / e1 - 1.0), d.z()));
  // f is homogeneous of degree 2/e1.
  return {std::pow(f, -0.5 * e1) * d, gradient.stableNormalized()};
}

/// The directions from a solid's centre, through the six faces of a cube, each of kCells x kCells cells.
constexpr Index kCells = 64;

/// Returns the direction through the point (s, t) of a cell, both from 0 to 1.
Vector3d cube_direction(Index cell, double s, double t) {
  const Index face = cell / (kCells * kCells), row = cell / kCells % kCells, column = cell % kCells;
  const auto axis = static_cast<int>(face / 2);
  Vector3d d;
  d[axis] = face % 2 == 0 ? -1.0 : 1.0;
  d[(axis + 1) % 3] = 2.0 * (static_cast<double>(row) + s) / static_cast<double>(kCells) - 1.0;
  d[(axis + 2) % 3] = 2.0 * (static_cast<double>(column) + t) / static_cast<double>(kCells) - 1.0;
  return d;
}

}  // namespace

PointCloud sample_box(const Vector3d& size_m, Index count, std::uint32_t seed) {
  require_lengths({size_m.x(), size_m.y(), size_m.z()});
  // The faces one after another: x-, x+, y-, y+, z-, z+.
  std::vector<double> areas_m2(6);
  for (int face = 0; face < 6; ++face) areas_m2[face] = size_m.prod() / size_m[face / 2];
  return sample_blue_noise(areas_m2, count, seed, [&](Index face, Uniform& uniform) {
    const Index axis = face / 2;
    const double side = face % 2 == 0 ? -1.0 : 1.0;
    Vector3d p;
    for (int k = 0; k < 3; ++k) p[k] = size_m[k] * (uniform() - 0.5);
    p[axis] = 0.5 * side * size_m[axis];
    return SurfaceSample{p, side * Vector3d::Unit(axis)};
  });
}

PointCloud sample_sphere(double radius_m, Index count, std::uint32_t seed) {
  require_lengths({radius_m});
  return sample_blue_noise({4.0 * pi * radius_m * radius_m}, count, seed, [&](Index, Uniform& uniform) {
    // Archimedes: the area between two heights is proportional to their difference.
    const double z = 2.0 * uniform() - 1.0;
    const double angle = 2.0 * pi * uniform();
    const double r = std::sqrt(1.0 - z * z);
    const Vector3d normal = Vector3d(r * std::cos(angle), r * std::sin(angle), z).normalized();
    return SurfaceSample{radius_m * normal, normal};
  });
}

PointCloud sample_ellipsoid(const Vector3d& size_m, Index count, std::uint32_t seed) {
  return sample_superquadric(size_m, {1.0, 1.0}, count, seed);
}

PointCloud sample_cylinder(double radius_m, double length_m, Index count, std::uint32_t seed) {
  require_lengths({radius_m, length_m});
  const double end_m = 0.5 * length_m, cap_m2 = ring_area_m2(0.0, radius_m);
  return sample_blue_noise({cap_m2, wall_area_m2(radius_m, length_m), cap_m2}, count, seed,
                           [&](Index piece, Uniform& uniform) {
                             if (piece == 0) return draw_ring(0.0, radius_m, -end_m, -1.0, uniform);
                             if (piece == 2) return draw_ring(0.0, radius_m, end_m, 1.0, uniform);
                             return draw_wall(radius_m, -end_m, end_m, 1.0, uniform);
                           });
}

PointCloud sample_superquadric(const Vector3d& size_m, const Exponents& e, Index count, std::uint32_t seed) {
  require_lengths({size_m.x(), size_m.y(), size_m.z()});
  for (const double exponent : {e.north_south, e.east_west}) {
    if (exponent >= kLeastExponent && exponent <= kLargestExponent) continue;
    throw std::invalid_argument("the exponents of a superquadric must lie within 0.1 .. 2");
  }
  const Vector3d half_m = 0.5 * size_m;
  const auto sample = [&](Index cell, double s, double t) {
    const SurfaceSample unit = on_unit_superquadric(e, cube_direction(cell, s, t));
    // Stretched: points by the half sizes, gradients by their inverses.
    return SurfaceSample{unit.point_m.cwiseProduct(half_m), unit.normal.cwiseQuotient(half_m).stableNormalized()};
  };
  // A cell by its two triangles.
  std::vector<double> areas_m2(6 * kCells * kCells);
  for (Index cell = 0; cell < static_cast<Index>(areas_m2.size()); ++cell) {
    const Vector3d a = sample(cell, 0.0, 0.0).point_m, b = sample(cell, 1.0, 0.0).point_m;
    const Vector3d c = sample(cell, 1.0, 1.0).point_m, d = sample(cell, 0.0, 1.0).point_m;
    areas_m2[cell] = 0.5 * ((b - a).cross(c - a).norm() + (c - a).cross(d - a).norm());
  }
  // Within a cell directions are drawn evenly, which is almost even by area; the elimination levels the rest.
  return sample_blue_noise(areas_m2, count, seed, [&](Index cell, Uniform& uniform) {
    const double s = uniform(), t = uniform();
    return sample(cell, s, t);
  });
}

bool Mug::handle_fits() const {
  if (!handle) return true;
  const double half_m = handle->radius_m + 0.5 * handle->thickness_m;
  return 0.5 * handle->thickness_m < handle->radius_m && half_m < 0.5 * height_m && half_m < radius_m;
}

Vector3d centroid_m(const Mug& mug) {
  const double inner_m = mug.radius_m - mug.wall_m;
  const double hollow_m3 = pi * inner_m * inner_m * (mug.height_m - mug.wall_m);  // Its centroid is wall/2 high.
  const double cup_m3 = pi * mug.radius_m * mug.radius_m * mug.height_m - hollow_m3;
  const VolumeMoment handle = mug.handle ? handle_volume(mug) : VolumeMoment{};
  return Vector3d(handle.moment_m4, 0.0, -hollow_m3 * 0.5 * mug.wall_m) / (cup_m3 + handle.volume_m3);
}

PointCloud sample_mug(const Mug& mug, Index count, std::uint32_t seed) {
  require_lengths({mug.radius_m, mug.height_m, mug.wall_m});
  if (mug.handle) require_lengths({mug.handle->radius_m, mug.handle->thickness_m});
  if (mug.wall_m >= mug.radius_m || mug.wall_m >= mug.height_m) {
    throw std::invalid_argument("a mug's wall must be thinner than its radius and its height");
  }
  if (!mug.handle_fits()) throw std::invalid_argument("the handle of the mug must be a ring, and smaller than the mug");

  const double outer_m = mug.radius_m, inner_m = mug.radius_m - mug.wall_m;
  const double bottom_m = -0.5 * mug.height_m, floor_m = bottom_m + mug.wall_m, top_m = 0.5 * mug.height_m;
  enum Piece : Index { kBottom, kOuterWall, kRim, kInnerWall, kFloor, kHandle };
  std::vector<double> areas_m2 = {ring_area_m2(0.0, outer_m), wall_area_m2(outer_m, mug.height_m),
                                  ring_area_m2(inner_m, outer_m), wall_area_m2(inner_m, top_m - floor_m),
                                  ring_area_m2(0.0, inner_m)};
  if (mug.handle) areas_m2.push_back(2.0 * pi * mug.handle->radius_m * pi * mug.handle->thickness_m);

  return sample_blue_noise(areas_m2, count, seed, [&](Index piece, Uniform& uniform) -> std::optional<SurfaceSample> {
    switch (piece) {
      case kBottom:
        return draw_ring(0.0, outer_m, bottom_m, -1.0, uniform);
      case kRim:
        return draw_ring(inner_m, outer_m, top_m, 1.0, uniform);
      case kInnerWall:
        return draw_wall(inner_m, floor_m, top_m, -1.0, uniform);
      case kFloor:
        return draw_ring(0.0, inner_m, floor_m, 1.0, uniform);
      case kOuterWall: {
        const SurfaceSample sample = draw_wall(outer_m, bottom_m, top_m, 1.0, uniform);
        if (is_inside_handle(mug, sample.point_m)) return std::nullopt;
        return sample;
      }
      default: {
        const SurfaceSample sample = draw_torus(mug, uniform);
        if (sample.point_m.head<2>().norm() < outer_m) return std::nullopt;
        return sample;
      }
    }
  });
}

}  // namespace thenar
