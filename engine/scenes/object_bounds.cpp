// SPDX-License-Identifier: Apache-2.0
#include "engine/scenes/object_bounds.h"

#include <fmt/format.h>

#include <algorithm>

namespace thenar {

using Eigen::Vector3d;

namespace {

/// The box around a shape, in its frame; nothing for one from a file.
struct BoundShape {
  static Eigen::AlignedBox3d around(const Vector3d& size_m) { return {-0.5 * size_m, 0.5 * size_m}; }
  Eigen::AlignedBox3d operator()(const BoxShape& box) const { return around(box.size_m); }
  Eigen::AlignedBox3d operator()(const SphereShape& sphere) const {
    return around(Vector3d::Constant(2.0 * sphere.radius_m));
  }
  Eigen::AlignedBox3d operator()(const EllipsoidShape& ellipsoid) const { return around(ellipsoid.size_m); }
  Eigen::AlignedBox3d operator()(const CylinderShape& cylinder) const {
    return around({2.0 * cylinder.radius_m, 2.0 * cylinder.radius_m, cylinder.length_m});
  }
  Eigen::AlignedBox3d operator()(const SuperquadricShape& shape) const { return around(shape.size_m); }
  Eigen::AlignedBox3d operator()(const Mug& mug) const {
    Eigen::AlignedBox3d box = around({2.0 * mug.radius_m, 2.0 * mug.radius_m, mug.height_m});
    if (mug.handle) box.max().x() += mug.handle->radius_m + 0.5 * mug.handle->thickness_m;
    return box;
  }
  Eigen::AlignedBox3d operator()(const CloudShape& /*scan*/) const { return {}; }
};

}  // namespace

void check_is_in_object(Visitor& v, std::string_view key, const Vector3d& point_m, const Shape& shape) {
  constexpr double kRounding_m = 1e-9;
  const Eigen::AlignedBox3d box = std::visit(BoundShape{}, shape);
  if (box.isEmpty() || box.exteriorDistance(point_m) <= kRounding_m) return;
  v.refuse(key, "must lie within the object: " + in_words(box) + " in its frame");
}

std::string in_words(const Eigen::AlignedBox3d& box) {
  const Vector3d low_mm = 1e3 * box.min(), high_mm = 1e3 * box.max();
  return fmt::format("{:.4g} .. {:.4g}, {:.4g} .. {:.4g}, {:.4g} .. {:.4g} mm", low_mm.x(), high_mm.x(), low_mm.y(),
                     high_mm.y(), low_mm.z(), high_mm.z());
}

}  // namespace thenar
