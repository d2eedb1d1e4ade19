// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <numbers>
#include <utility>
#include <variant>

#include "engine/grasp/scene.h"

namespace thenar {

/// How a hole misses a peg, and how the two meet.
struct PegMiss {
  double tilt_deg = 1.0, aside_m = 0.5e-3;
  double clearance_m = 0.2e-3, friction = 0.2;
  bool tip = true;      ///< The centre of control is the peg's tip, else its middle.
  double over_s = 2.0;  ///< Of the hole's move, 26 mm.
  double rotation_Nm_per_rad = 0.48;
};

/// The scene configs/peg.yaml with such a hole, which comes along its own axis from 1 mm below the peg's end.
[[nodiscard]] inline Scene with_miss(Scene scene, const PegMiss& miss) {
  constexpr double kBegins_m = 1e-3, kDepth_m = 25e-3, kFrom_s = 0.5, kRest_s = 0.5;
  const CylinderShape& peg = std::get<CylinderShape>(scene.object.shape);
  const Eigen::AngleAxisd tilt(miss.tilt_deg * std::numbers::pi / 180.0, Eigen::Vector3d::UnitY());
  EnvironmentBody& hole = scene.environment->bodies.front();
  hole.X_WE = scene.object.X_WO * Eigen::Translation3d(miss.aside_m, 0.0, -0.5 * peg.length_m) * tilt *
              Eigen::Translation3d(0.0, 0.0, -kBegins_m);
  hole.friction = miss.friction;
  hole.moves = {{(kBegins_m + kDepth_m) * hole.X_WE.linear().col(2), kFrom_s, miss.over_s}};
  std::get<HoleShape>(hole.shape).radius_m = peg.radius_m + 0.5 * miss.clearance_m;
  scene.duration_s = kFrom_s + miss.over_s + kRest_s;
  if (!miss.tip) scene.control->centre_m.reset();
  scene.control->rotation.p = miss.rotation_Nm_per_rad;
  return scene;
}

}  // namespace thenar
