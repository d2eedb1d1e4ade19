// SPDX-License-Identifier: Apache-2.0
/// Exact shapes of all kinds with samples of their surfaces, and the textbook's formulas for them.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "collision/solids/exact_shape.h"

namespace thenar::exact_shapes {

using Eigen::Index;
using Eigen::Vector3d;

inline const Mug kMug{40e-3, 90e-3, 4e-3, MugHandle{25e-3, 10e-3}};

struct Case {
  std::string name;
  ExactShape shape;
  PointCloud cloud;
};

inline PointCloud sample(const ExactShape& shape, Index count) {
  return std::visit(
      [&](const auto& body) {
        using Body = std::decay_t<decltype(body)>;
        if constexpr (std::is_same_v<Body, BoxShape>) return sample_box(body.size_m, count);
        if constexpr (std::is_same_v<Body, SphereShape>) return sample_sphere(body.radius_m, count);
        if constexpr (std::is_same_v<Body, EllipsoidShape>) return sample_ellipsoid(body.size_m, count);
        if constexpr (std::is_same_v<Body, CylinderShape>) return sample_cylinder(body.radius_m, body.length_m, count);
        if constexpr (std::is_same_v<Body, SuperquadricShape>)
          return sample_superquadric(body.size_m, body.exponents, count);
        if constexpr (std::is_same_v<Body, Mug>) return sample_mug(body, count);
      },
      shape);
}

/// One of each shape, and superquadrics from nearly a box to an octahedron; with 4000 samples each.
inline const std::vector<Case>& cases() {
  static const std::vector<Case> kAll = [] {
    std::vector<Case> some;
    const auto add = [&](const char* name, const ExactShape& shape) {
      some.push_back({name, shape, sample(shape, 4000)});
    };
    const Vector3d size_m(40e-3, 50e-3, 60e-3);
    add("box", BoxShape{{50e-3, 60e-3, 80e-3}});
    add("sphere", SphereShape{25e-3});
    add("ellipsoid", EllipsoidShape{size_m});
    add("flat ellipsoid", EllipsoidShape{{20e-3, 80e-3, 50e-3}});
    add("cylinder", CylinderShape{20e-3, 70e-3});
    add("mug", kMug);
    add("mug without a handle", Mug{30e-3, 80e-3, 3e-3, std::nullopt});
    for (const auto& [e1, e2] : {std::pair(0.1, 0.1),
                                 {0.2, 1.0},
                                 {0.3, 0.6},
                                 {0.6, 0.8},
                                 {1.0, 1.0},
                                 {1.0, 0.3},
                                 {0.5, 1.5},
                                 {1.5, 0.5},
                                 {1.3, 1.2},
                                 {1.9, 1.9},
                                 {2.0, 1.0},
                                 {2.0, 2.0}}) {
      add(("superquadric " + std::to_string(e1) + " " + std::to_string(e2)).c_str(),
          SuperquadricShape{size_m, {e1, e2}});
    }
    return some;
  }();
  return kAll;
}

inline bool is_superquadric(const Case& one) { return std::holds_alternative<SuperquadricShape>(one.shape); }

/// Whether a superquadric's curvature is infinite where it meets a plane of symmetry.
inline bool has_creases(const Case& one) {
  const auto* shape = std::get_if<SuperquadricShape>(&one.shape);
  return shape != nullptr && (shape->exponents.north_south > 1.0 || shape->exponents.east_west > 1.0);
}

class Random {
 public:
  explicit Random(unsigned seed) : bits_(seed) {}
  double between(double low, double high) { return std::uniform_real_distribution<double>(low, high)(bits_); }
  Vector3d in_cube(double half) { return {between(-half, half), between(-half, half), between(-half, half)}; }
  Vector3d direction() { return Vector3d(normal_(bits_), normal_(bits_), normal_(bits_)).normalized(); }

 private:
  std::mt19937 bits_;
  std::normal_distribution<double> normal_;
};

/// How far a place is off the surface of a face, by the textbook's formula: a length that is 0 on it, to first order.
inline double off_face_m(const ExactShape& shape, int face, const Vector3d& s) {
  const double rho = s.head<2>().norm();
  if (const auto* box = std::get_if<BoxShape>(&shape))
    return s[face / 2] * (face % 2 == 0 ? -1.0 : 1.0) - 0.5 * box->size_m[face / 2];
  if (const auto* sphere = std::get_if<SphereShape>(&shape)) return s.norm() - sphere->radius_m;
  if (const auto* cylinder = std::get_if<CylinderShape>(&shape)) {
    if (face == 0) return rho - cylinder->radius_m;
    return s[2] - (face == 1 ? -0.5 : 0.5) * cylinder->length_m;
  }
  if (const auto* body = std::get_if<EllipsoidShape>(&shape)) {
    const Vector3d half_m = 0.5 * body->size_m;
    return half_m.minCoeff() * (s.cwiseQuotient(half_m).squaredNorm() - 1.0);
  }
  if (const auto* body = std::get_if<SuperquadricShape>(&shape)) {
    const Vector3d a = s.cwiseQuotient(0.5 * body->size_m).cwiseAbs();
    const double e1 = body->exponents.north_south, e2 = body->exponents.east_west;
    const double f = std::pow(std::pow(a[0], 2.0 / e2) + std::pow(a[1], 2.0 / e2), e2 / e1) + std::pow(a[2], 2.0 / e1);
    return 0.5 * body->size_m.minCoeff() * (std::pow(f, 0.5 * e1) - 1.0);
  }
  const auto& mug = std::get<Mug>(shape);
  const double half_m = 0.5 * mug.height_m;
  if (face == 5) {
    const double ring_m = std::hypot(s[0] - mug.radius_m, s[2]) - mug.handle->radius_m;
    return std::hypot(ring_m, s[1]) - 0.5 * mug.handle->thickness_m;
  }
  const std::array<double, 5> off_m{s[2] + half_m, rho - mug.radius_m, s[2] - half_m, rho - mug.radius_m + mug.wall_m,
                                    s[2] - mug.wall_m + half_m};
  return off_m.at(face);
}

}  // namespace thenar::exact_shapes
