// SPDX-License-Identifier: Apache-2.0
#include "tests/support/scenes.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <filesystem>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "bench/cases/scene_run.h"
#include "engine/grasp/model.h"
#include "engine/grasp/scene.h"
#include "engine/scenes/scene_file.h"

namespace thenar {

std::filesystem::path config_file(const std::string& name) {
  return std::filesystem::path(THENAR_CONFIGS) / (name + ".yaml");
}

Scene scene_of(const std::string& name, const std::vector<std::string>& overrides) {
  return load_scene(config_file(name), overrides);
}

Scene split_scene() { return scene_of("box_grasp", {kCoarseBox, "time.step=1 ms", "time.control_period=5 ms"}); }

bool is_finite(const State& state) {
  bool finite = state.q.allFinite() && state.X_WO.matrix().allFinite();
  for (const auto& u : state.u_m) finite = finite && u.allFinite();
  for (const ContactForce& force : state.forces) finite = finite && force.f_C.allFinite();
  for (const FingerLoad& load : state.load) {
    finite = finite && load.force_N.allFinite() && load.centre_m.allFinite() && load.normal.allFinite();
  }
  return finite;
}

Scene pressed_thumb(double depth_m, const Eigen::Vector3d& force_C, double translation_damping,
                    const Eigen::Vector3d& normal_F) {
  Scene scene = scene_of("box_grasp", {"object.shape={box: [20 mm, 20 mm, 20 mm]}", "object.points=3000"});
  scene.control.reset();
  scene.task = {};
  scene.torques = scene.hand.at_zero();
  scene.joint_viscosity = 1e9;
  scene.object.rotation_damping = 1e9;
  scene.object.translation_damping = translation_damping;

  const Fingertip& tip = scene.hand.fingertips[0];
  HandPose pose;
  forward_kinematics(scene.hand, scene.posture, pose);
  const Eigen::Isometry3d& X_WF = pose.distal(scene.hand, 0);
  Eigen::Matrix3d axes;  // into the box, and two tangents
  axes.col(0) = X_WF.linear() * (normal_F.isZero(0.0) ? tip.normal : normal_F);
  axes.col(1) = axes.col(0).unitOrthogonal();
  axes.col(2) = axes.col(0).cross(axes.col(1));
  scene.object.X_WO.linear() = axes;
  scene.object.X_WO.translation() = X_WF * tip.centre_m + (tip.radius_m - depth_m + 10e-3) * axes.col(0);
  scene.gravity = axes * force_C / scene.object.mass_kg;
  return scene;
}

double uniform(std::mt19937_64& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

Eigen::Vector3d random_direction(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  const double x = normal(random), y = normal(random), z = normal(random);
  return Eigen::Vector3d(x, y, z).normalized();
}

Eigen::Matrix3d random_rotation(std::mt19937_64& random) {
  const Eigen::Vector3d axis = random_direction(random);
  return Eigen::AngleAxisd(uniform(random, 0.0, 3.1), axis).toRotationMatrix();
}

Eigen::Isometry3d random_rotation_about(const Eigen::Vector3d& point, std::mt19937_64& random) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() = random_rotation(random);
  X.translation() = point - X.linear() * point;
  return X;
}

}  // namespace thenar
