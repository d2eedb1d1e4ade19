// SPDX-License-Identifier: Apache-2.0
#include "engine/imports/mjcf_geom.h"

#include <fmt/format.h>

#include <numbers>

namespace thenar {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

constexpr double kWaterDensity = 1000.0;  // [kg/m^3] MJCF's default for a geom with neither mass nor density.

bool is_wide(const std::string& type) { return type == "box" || type == "ellipsoid"; }

/// Returns half sizes: of a capsule or a cylinder the radius and half of the length. With `fromto` the first alone is
/// needed: the one along z follows from the ends, and that across of a box or an ellipsoid is the first.
Vector3d size_of(const XmlElement& geom, const std::string& type) {
  const VectorXd size = numbers(geom, "size", 1, 3).value_or(VectorXd::Zero(3));
  const bool is_long = type == "capsule" || type == "cylinder";
  const Eigen::Index needed = geom.find("fromto") != nullptr ? 1 : is_wide(type) ? 3 : is_long ? 2 : 1;
  const bool has_size = is_wide(type) || is_long || type == "sphere";
  if (has_size && size.size() < needed) refuse(geom, fmt::format("a {} needs {} sizes", type, needed));
  if (size.minCoeff() < 0.0) refuse(geom, "size: must not be negative");
  Vector3d all = Vector3d::Zero();
  all.head(size.size()) = size;
  return all;
}

std::optional<double> volume_m3(const std::string& type, const Vector3d& size) {
  constexpr double kPi = std::numbers::pi;
  if (type == "sphere") return 4.0 / 3.0 * kPi * size[0] * size[0] * size[0];
  if (type == "ellipsoid") return 4.0 / 3.0 * kPi * size.prod();
  if (type == "box") return 8.0 * size.prod();
  if (type == "cylinder") return 2.0 * kPi * size[0] * size[0] * size[1];
  if (type == "capsule") return kPi * size[0] * size[0] * (2.0 * size[1] + 4.0 / 3.0 * size[0]);
  return std::nullopt;
}

std::optional<TreeRound> round_of(const MjcfGeom& geom, const Vector3d& size) {
  constexpr double kLeastHalf_m = 0.5e-4;  // Shorter, and it is a sphere.
  TreeRound round{geom.radius_m, std::nullopt, geom.X_BG.translation()};
  if (geom.type == "ellipsoid") {
    round.shape = PulpShape{PulpShape::Form::kEllipsoid, geom.X_BG.linear(), size};
    round.radius_m = size.minCoeff();
  } else if (geom.type == "capsule" && size[1] >= kLeastHalf_m) {
    Eigen::Matrix3d turned;  // MJCF's is along z, a pulp's along its first axis.
    turned << geom.X_BG.linear().col(2), geom.X_BG.linear().col(0), geom.X_BG.linear().col(1);
    round.shape = PulpShape{PulpShape::Form::kCapsule, turned, {size[1], size[0], size[0]}};
  } else if (geom.type != "sphere" && geom.type != "capsule") {
    return std::nullopt;
  }
  return round;
}

}  // namespace

MjcfGeom read_geom(const XmlElement& element, const MjcfAngles& angles, const Isometry3d& X_BF) {
  MjcfGeom geom;
  geom.type = element.find("type") != nullptr ? element.text("type") : "sphere";
  if (geom.type != "mesh" && element.find("mesh") != nullptr) {
    refuse(element, fmt::format("is a {} fitted to a mesh, which is not read: write its size and place", geom.type));
  }
  Vector3d size = size_of(element, geom.type);
  geom.X_BG = X_BF * pose_of(element, angles);
  if (const auto ends = ends_of(element, geom.type)) {
    geom.X_BG = X_BF * ends->X_FG;
    size[1] = ends->half_m;
    if (is_wide(geom.type)) size = Vector3d(size[0], size[0], ends->half_m);
  }
  geom.radius_m = size[0];
  const double density = number(element, "density").value_or(kWaterDensity);
  if (density < 0.0) refuse(element, "density: must not be negative");
  const std::optional<double> volume = volume_m3(geom.type, size);
  geom.mass_kg = number(element, "mass");
  if (geom.mass_kg && *geom.mass_kg < 0.0) refuse(element, "mass: must not be negative");
  if (!geom.mass_kg && volume) geom.mass_kg = density * *volume;
  if (density == 0.0 && !geom.mass_kg) geom.mass_kg = 0.0;
  if (geom.type == "plane") geom.mass_kg = 0.0;
  geom.round = round_of(geom, size);
  return geom;
}

}  // namespace thenar
