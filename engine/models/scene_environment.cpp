// SPDX-License-Identifier: Apache-2.0
#include "engine/models/scene_environment.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include "collision/solids/sampled_solid.h"
#include "engine/environment/room_for.h"
#include "engine/scenes/config.h"

namespace thenar {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// Returns axes of which z is `up` (unit): x is the object's x made level, or its y where that is upright.
Matrix3d level_axes(const Vector3d& up) {
  const Vector3d ahead = std::abs(up.x()) < 0.9 ? Vector3d::UnitX() : Vector3d::UnitY();
  Matrix3d axes;
  axes.col(2) = up;
  axes.col(0) = (ahead - ahead.dot(up) * up).normalized();
  axes.col(1) = up.cross(Vector3d(axes.col(0)));
  return axes;
}

/// Returns the height of a solid over the plane through its origin across `up` (unit): that of its lowest point.
double lowest_m(const TouchingSolid& solid, const Vector3d& up) {
  constexpr double kAbove_m = 0.1e-3, kBand_m = 1e-3;
  const SolidPair pair(solid, HalfSpace{});
  Isometry3d level = Isometry3d::Identity();
  level.linear() = level_axes(up).transpose();
  const auto least_gap_m = [&](double height_m, double band_m) {
    std::vector<SolidContact> contacts;
    contacts.reserve(most_contacts(solid, HalfSpace{}));
    level.translation().z() = height_m;
    find_contacts(pair, level, band_m, contacts);
    double least_m = band_m;
    for (const SolidContact& contact : contacts) least_m = std::min(least_m, contact.gap_m);
    return least_m;
  };
  // First from afar, and then as close as the contacts of a run are.
  const double reach = reach_m(solid);
  const double far_m = least_gap_m(reach, 3.0 * reach) - reach;
  return least_gap_m(kAbove_m - far_m, kBand_m) - (kAbove_m - far_m);
}

/// Returns the distance from a solid's middle to its top.
double top_m(const Solid& solid) {
  if (const auto* box = std::get_if<BoxShape>(&solid)) return 0.5 * box->size_m.z();
  if (const auto* cylinder = std::get_if<CylinderShape>(&solid)) return 0.5 * cylinder->length_m;
  return 0.0;
}

}  // namespace

TouchingSolid touching_object(const Scene& scene, const std::shared_ptr<const SampledSolid>& sampled) {
  const std::optional<Solid> exact = solid_of(scene.object.shape);
  return exact ? TouchingSolid(*exact) : TouchingSolid(sampled);
}

void stand_object(Scene& scene, const TouchingSolid& object) {
  if (!scene.environment) return;
  Environment& environment = *scene.environment;
  const Isometry3d& X_WO = scene.object.X_WO;
  const Vector3d gravity_O =
      scene.gravity_in_object_frame ? scene.gravity : Vector3d(X_WO.linear().transpose() * scene.gravity);
  for (EnvironmentBody& body : environment.bodies) {
    if (!body.under_gap_m) continue;
    const Vector3d up = -gravity_O.normalized(), centre = scene.object.centre_of_mass_m;
    Isometry3d X_OE = Isometry3d::Identity();
    X_OE.linear() = level_axes(up);
    const double height_m = lowest_m(object, up) - *body.under_gap_m - top_m(body.shape);
    X_OE.translation() = centre + (height_m - centre.dot(up)) * up;
    body.X_WE = environment.in_object_frame ? X_OE : X_WO * X_OE;
    body.under_gap_m.reset();
  }
}

namespace {

bool has_body_under(const Scene& scene) {
  const auto is_under = [](const EnvironmentBody& body) { return body.under_gap_m.has_value(); };
  return scene.environment && std::ranges::any_of(scene.environment->bodies, is_under);
}

}  // namespace

void stand_object(Scene& scene, const ImplicitSurface& object) {
  if (!has_body_under(scene)) return;
  std::shared_ptr<const SampledSolid> sampled;
  if (!solid_of(scene.object.shape)) sampled = std::make_shared<const SampledSolid>(object.cloud());
  stand_object(scene, touching_object(scene, sampled));
}

bool stands_in_object_frame(const Scene& scene) {
  return has_body_under(scene) && scene.environment->in_object_frame && scene.gravity_in_object_frame;
}

void place_by_object(Scene& scene) {
  const Isometry3d& X_WO = scene.object.X_WO;
  if (scene.gravity_in_object_frame) scene.gravity = X_WO.linear() * scene.gravity;
  scene.gravity_in_object_frame = false;
  if (!scene.environment || !scene.environment->in_object_frame) return;
  scene.environment->in_object_frame = false;
  for (EnvironmentBody& body : scene.environment->bodies) {
    body.X_WE = X_WO * body.X_WE;
    for (EnvironmentMove& move : body.moves) move.by_m = X_WO.linear() * move.by_m;
  }
  if (!scene.task.goal) return;
  TaskGoal& goal = *scene.task.goal;
  if (goal.position_m) goal.position_m = X_WO * *goal.position_m;
  if (goal.rotation) goal.rotation = X_WO.linear() * *goal.rotation;
}

void check_room(const Scene& scene, const TouchingSolid& object, bool is_found) {
  if (!scene.environment) return;
  const auto overlap = find_overlap(*scene.environment, object, scene.object.X_WO);
  if (!overlap) return;
  const auto at = [&](const Overlap::Place& place) {
    const Vector3d p_mm = 1e3 * place.p_E;
    return fmt::format("'{}' at ({:.3g}, {:.3g}, {:.3g}) mm of its frame", scene.environment->bodies[place.body].name,
                       p_mm.x(), p_mm.y(), p_mm.z());
  };
  const std::string fault =
      overlap->against
          ? fmt::format(
                "the object does not fit: {} and {} press against one another by {:.3g} mm, and no motion of it "
                "opens both",
                at(overlap->deepest), at(*overlap->against), 1e3 * overlap->depth_m)
          : fmt::format("the object lies {:.3g} mm deep in {}: move one of them{}", 1e3 * overlap->depth_m,
                        at(overlap->deepest),
                        is_found ? ", or place the bodies by the object, wherever the grasp that is found has it: "
                                   "environment.frame: object, and under: object for what it stands on"
                                 : "");
  throw ConfigError({{scene.environment->place, fmt::format("environment.bodies[{}]", overlap->deepest.body), fault}});
}

}  // namespace thenar
