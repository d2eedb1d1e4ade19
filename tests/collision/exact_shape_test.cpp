#include "collision/solids/exact_shape.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <vector>

namespace thenar::exact_shape_test {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

const Mug kMug{40e-3, 90e-3, 4e-3, MugHandle{25e-3, 10e-3}};
const double kInner_m = kMug.radius_m - kMug.wall_m, kTop_m = 0.5 * kMug.height_m, kFloor_m = kMug.wall_m - kTop_m;

struct Case {
  std::string name;
  ExactShape shape;
  PointCloud cloud;
};

PointCloud sample(const ExactShape& shape, Index count) {
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
const std::vector<Case>& cases() {
  static const std::vector<Case> all = [] {
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
    for (const auto& [e1, e2] : {std::pair(0.1, 0.1), {0.2, 1.0}, {0.3, 0.6}, {0.6, 0.8}, {1.0, 1.0}, {1.0, 0.3},
                                 {0.5, 1.5}, {1.5, 0.5}, {1.3, 1.2}, {1.9, 1.9}, {2.0, 1.0}, {2.0, 2.0}}) {
      add(("superquadric " + std::to_string(e1) + " " + std::to_string(e2)).c_str(),
          SuperquadricShape{size_m, {e1, e2}});
    }
    return some;
  }();
  return all;
}

}  // namespace
}  // namespace thenar::exact_shape_test
