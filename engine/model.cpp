#include "engine/model.h"

#include <algorithm>
#include <cmath>

#include "engine/config.h"
#include "engine/fine_parts.h"
#include "engine/pulp_levels.h"

namespace thenar {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Vector3d;

namespace {

/// From 0 to 1 with no velocity and acceleration at both ends.
double minimum_jerk(const Move& move, double time_s) {
  const double s = std::clamp((time_s - move.from_s) / move.over_s, 0.0, 1.0);
  return s * s * s * (10.0 + s * (6.0 * s - 15.0));
}

/// Refuses places that a scene names in its object and that are not within its surface. The origin, which is where all of
/// them are unless named, may lie anywhere.
void check_places(const Model& model) {
  const Scene& scene = model.scene;
  const Eigen::AlignedBox3d& box = model.object.bounds();
  const auto check = [&](const Vector3d& point_m, const char* key) {
    // Samples end up to a support before the surface does.
    if (point_m.isZero(0.0) || box.exteriorDistance(point_m) <= model.object.support_m()) return;
    throw ConfigError({{scene.name, key, "must lie within the object: " + in_words(box) + " in its frame"}});
  };
  check(scene.object.centre_of_mass_m, "object.centre_of_mass");
  if (scene.task.push) check(scene.task.push->at_m, "task.push.at");
}

/// What depends on how many control points the pulps have.
void fit_to_controls(Model& model) {
  model.max_contacts = kFingers * std::min(model.scene.contact.max_per_finger, model.pulps.front().controls());
  double spacing_m = 0.0;  // of control points
  for (const Pulp& pulp : model.pulps) spacing_m = std::max(spacing_m, std::sqrt(pulp.area_m2.mean()));
  model.fine_m = fine_parts(model.object.cloud(), spacing_m);
}

void make_fingertips(Model& model) {
  const Scene& scene = model.scene;
  model.max_contacts = kFingers;
  if (!scene.fingertips) return;
  model.pulps = make_pulps(scene);
  if (scene.contact.level != 0) {
    model.level = scene.contact.level
                      ? *scene.contact.level
                      : choose_level(estimate_levels(scene, model.pulps), scene.contact.force_error).level;
    for (Pulp& pulp : model.pulps) set_level(pulp, model.level);
  }
  fit_to_controls(model);
}

}  // namespace

Model::Model(Scene s) : scene(std::move(s)), object(make_object_surface(scene, object_notes)) {
  check_places(*this);
  make_fingertips(*this);
}

Model::Model(Scene s, const Model& known)
    : scene(std::move(s)),
      object(have_same_surface(scene, known.scene) ? known.object : make_object_surface(scene, object_notes)) {
  if (have_same_surface(scene, known.scene)) object_notes = known.object_notes;
  check_places(*this);
  make_fingertips(*this);
}

void Model::set_fingertips(PulpKernel kernel, int detail) {
  scene.fingertips->material.kernel = kernel;
  level = detail;
  for (Pulp& pulp : pulps) {
    pulp.material.kernel = kernel;
    set_level(pulp, level);
  }
  fit_to_controls(*this);
}

bool Model::control_is_due(std::int64_t tick) const {
  // A period that ends at a step's start, but for rounding, ends there.
  const auto periods = [&](std::int64_t t) {
    return std::floor(static_cast<double>(t) * scene.step_s / scene.control_period_s + 1e-6);
  };
  return tick == 0 || periods(tick) > periods(tick - 1);
}

Isometry3d Model::target(double time_s) const {
  Isometry3d X_WT = scene.object.X_WO;
  if (const auto& move = scene.task.translate) X_WT.translate(minimum_jerk(*move, time_s) * move->amount * move->axis);
  if (const auto& move = scene.task.rotate) {
    X_WT.rotate(Eigen::AngleAxisd(minimum_jerk(*move, time_s) * move->amount, move->axis));
  }
  return X_WT;
}

Vector6d Model::weight(const Isometry3d& X_WO) const {
  Vector6d wrench;
  wrench.head<3>() = scene.object.mass_kg * scene.gravity;
  wrench.tail<3>() = (X_WO.linear() * scene.object.centre_of_mass_m).cross(Vector3d(wrench.head<3>()));
  return wrench;
}

Vector6d Model::external_wrench(double time_s, const Isometry3d& X_WO) const {
  Vector6d wrench = weight(X_WO);
  const auto& push = scene.task.push;
  if (!push || time_s < push->from_s || time_s >= push->from_s + push->over_s) return wrench;
  const Eigen::Matrix3d& axes = scene.object.X_WO.linear();
  const Vector3d force_N = axes * push->force_N;
  wrench.head<3>() += force_N;
  wrench.tail<3>() += (X_WO.linear() * push->at_m).cross(force_N) + axes * push->moment_Nm;
  return wrench;
}

}  // namespace thenar
