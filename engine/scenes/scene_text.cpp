// SPDX-License-Identifier: Apache-2.0
#include "engine/scenes/scene_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "collision/cloud_repair.h"
#include "collision/point_grid.h"
#include "engine/finder/effort.h"
#include "engine/formats/text.h"
#include "engine/scenes/config_writer.h"
#include "engine/scenes/describe.h"
#include "engine/scenes/units.h"

namespace thenar {

using Eigen::Vector3d;

std::string scene_text(const Scene& scene, const SceneTextNotes& notes) {
  SceneFile file;
  file.scene = scene;
  file.hand = notes.hand;
  if (notes.names_fingers) {
    for (const Fingertip& tip : scene.hand.fingertips) file.fingers.push_back(tip.finger);
  }
  if (auto* cloud = std::get_if<CloudShape>(&file.scene.object.shape)) cloud->file = notes.object;
  const std::string text = config_text([&](Visitor& v) { describe(v, file); }, &scene.hand);
  const std::string schema =
      notes.schema.empty() ? "" : "# yaml-language-server: $schema=" + notes.schema.string() + "\n";
  return schema + yaml_comment(notes.about) + yaml_comment(notes.grasp) + text;
}

Scene scene_to_begin_with(const Hand& hand, const CloudShape& object, double mass_kg, double friction) {
  Scene scene;
  scene.name = object.file.stem().string();
  scene.duration_s = 2.0;
  scene.step_s = scene.control_period_s = 1e-3;
  scene.gravity = {7.01862, 5.581331, 3.977916};  // the palm looks up and to the side, as in the published experiment
  scene.hand = hand;
  scene.posture = hand.at_zero();
  scene.joint_viscosity = 0.05;
  scene.grasp = GraspWish{};
  scene.fingertips = FingertipSettings{2400, 320, {0.24e6, 0.5, 2e-3}};
  scene.object.shape = object;
  scene.object.points = 20000;
  scene.object.mass_kg = mass_kg;
  scene.object.translation_damping = 10.0;
  scene.object.rotation_damping = 0.005;
  scene.contact = {.friction = friction, .band_m = 0.3e-3, .max_per_finger = 30, .tolerance = 1e-7, .max_sweeps = 200};
  ControlSettings control;
  control.pulp_normal_N_per_m = 2000.0;
  control.pulp_tangential_N_per_m = 1330.0;
  control.grasp_friction = 0.7 * friction;
  // What carries the weight, and the push by which grasps are tried, by friction on both sides, and as much again.
  const double needed_N = (mass_kg * 9.81 + kPush_N) / std::max(friction, 0.1);
  control.internal_force_N = std::max(1.0, std::ceil(10.0 * needed_N) / 10.0);
  control.position = {300.0, 900.0, 0.0};
  control.rotation = {0.48, 1.5, 0.0};
  control.posture_Nm_per_rad = 0.5;
  if (!hand.muscles.empty()) control.muscles.emplace();
  scene.control = control;
  return scene;
}

namespace {

/// The areas that samples stand for, but for a common factor: scans are dense where the scanner was near. Estimates the
/// density around each by Epanechnikov's kernel; the other side of a thin wall does not count. Even samples stand for
/// one area each: around an edge the kernel finds more of them.
Eigen::VectorXd relative_areas(const PointCloud& cloud) {
  Eigen::VectorXd areas(cloud.points_m.cols());
  const double radius_m = 2.0 * covering_support_m(cloud);
  const PointGrid grid(cloud.points_m, radius_m);
  for (Eigen::Index i = 0; i < areas.size(); ++i) {
    double density = 1.0;
    grid.for_each_neighbour(i, [&](Eigen::Index j, double distance_m) {
      const double share = distance_m / radius_m;
      if (cloud.normals.col(i).dot(cloud.normals.col(j)) > -0.5) density += 1.0 - share * share;
    });
    areas[i] = 1.0 / density;
  }
  Eigen::VectorXd sorted = areas;
  std::nth_element(sorted.begin(), sorted.begin() + sorted.size() / 2, sorted.end());
  const Eigen::ArrayXd ratio = areas.array() / sorted[sorted.size() / 2];
  const bool is_even = 20 * (ratio > 1.5 || ratio < 1.0 / 1.5).count() < areas.size();
  return is_even ? Eigen::VectorXd::Ones(areas.size()) : areas;
}

}  // namespace

Vector3d enclosed_centroid_m(const PointCloud& cloud) {
  // By Gauss: V = 1/3 sum x.n A, V c_i = 1/2 sum x_i^2 n_i A, about the middle of the box.
  const Vector3d low = cloud.points_m.rowwise().minCoeff(), high = cloud.points_m.rowwise().maxCoeff();
  const Vector3d middle = 0.5 * (low + high);
  const Eigen::Matrix3Xd x = cloud.points_m.colwise() - middle;
  const Eigen::Matrix3Xd nA = cloud.normals * relative_areas(cloud).asDiagonal();
  const double volume = x.cwiseProduct(nA).sum() / 3.0;
  const Vector3d moment = 0.5 * x.cwiseAbs2().cwiseProduct(nA).rowwise().sum();
  if (!(volume > 0.0)) return middle;
  const Vector3d off = moment / volume;
  return (off.array().abs() < 0.5 * (high - low).array()).all() ? Vector3d(middle + off) : middle;
}

}  // namespace thenar
