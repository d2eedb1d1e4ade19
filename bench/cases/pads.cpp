// SPDX-License-Identifier: Apache-2.0
#include "bench/cases/pads.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include "bench/cases/scene_run.h"
#include "engine/grasp/scene.h"
#include "engine/grasp/slides.h"
#include "engine/scenes/scene_file.h"

namespace thenar {

Pads pads_round(const Shape& shape, double radius_m, int count) {
  Pads pads;
  pads.shape = shape;
  pads.curvature_per_m = 1.0 / radius_m;
  for (int k = 0; k < count; ++k) {
    const double angle = 2.0 * std::numbers::pi / count * k;
    const Eigen::Vector3d outward(std::cos(angle), std::sin(angle), 0.0);
    pads.pads.push_back({radius_m * outward, -outward});
  }
  return pads;
}

Pads pads_across(const Shape& shape, double width_m, double apart_m) {
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), side = 0.5 * width_m * x;
  const Eigen::Vector3d up(0.0, 0.0, 0.5 * apart_m);
  Pads pads;
  pads.shape = shape;
  pads.pads = {{-side, x, 2.0}, {side + up, -x, 1.0}, {side - up, -x, 1.0}};
  return pads;
}

Scene scene_of(const Pads& pads) {
  Scene scene = load_scene(std::filesystem::path(THENAR_CONFIGS) / "stick.yaml");
  scene.name = "pads";
  scene.task = {};
  scene.gravity = pads.gravity;
  scene.contact.friction = pads.friction;
  scene.control_period_s = scene.step_s;
  scene.object.shape = pads.shape;
  scene.object.points = 6000;
  scene.object.mass_kg = pads.mass_kg;
  scene.object.centre_of_mass_m = pads.centre_of_mass_m;
  scene.object.X_WO.setIdentity();
  // With the torsional stiffness of a patch some 6 ms; near the limit, where the patch all but slides, 0.1 s.
  scene.object.rotation_damping = 1e-4;
  scene.hand = hand_of_slides();
  scene.joint_viscosity = kSlideDamping_N_s_per_m;
  for (const Pad& pad : pads.pads) {
    const std::string name = "pad" + std::to_string(scene.slides.size() + 1);
    add_slide(name, pad.at_m - (kPad_m - pads.depth_m) * pad.inward, pad.inward, kPad_m, false, scene.hand);
    scene.slides.emplace_back().force_N = pad.force_N;
  }
  scene.posture = scene.hand.at_zero();
  scene.torques.reset();
  return scene;
}

bool hold(const Pads& pads) {
  Loop loop(scene_of(pads));
  const auto height_m = [&] { return -pads.gravity.normalized().dot(loop.state.X_WO * pads.centre_of_mass_m); };
  loop.run(0.5);
  const double built_up_m = height_m();
  loop.run(0.5);
  // At 15 degrees the lever is 3 % shorter: what turns further may come to hang, and fall no more.
  if (Eigen::AngleAxisd(loop.state.X_WO.linear()).angle() > 15.0 * std::numbers::pi / 180.0) return false;
  // What friction does not carry is left to the drag: 1 % of the weight of 100 g then falls at 1 mm/s.
  return built_up_m - height_m() < 0.1e-3;
}

double most_mass_kg(const Pads& pads, double reduced_modulus_Pa) {
  // Of a motion: velocity of the origin, rotation; of a load: force, moment.
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  // What a pad can do, by motions along its two tangents and turns.
  std::vector<Eigen::Matrix<double, 3, 6>> most(pads.pads.size());
  for (std::size_t k = 0; k < most.size(); ++k) {
    const Pad& pad = pads.pads[k];
    const Eigen::Vector3d n = pad.inward, t = n.unitOrthogonal();
    const double friction_N = pads.friction * pad.force_N;
    const double a_m = std::cbrt(0.75 * pad.force_N / (reduced_modulus_Pa * (1.0 / kPad_m + pads.curvature_per_m)));
    const auto row = [&](int r, const Eigen::Vector3d& axis) {
      most[k].row(r) << friction_N * axis.transpose(), friction_N * pad.at_m.cross(axis).transpose();
    };
    row(0, t);
    row(1, n.cross(t));
    most[k].row(2) << Eigen::RowVector3d::Zero(), 3.0 * std::numbers::pi / 16.0 * friction_N * a_m * n.transpose();
  }
  Vector6 weight;
  weight << pads.gravity, pads.centre_of_mass_m.cross(pads.gravity);
  std::vector<double> power(most.size(), 1.0);
  double sum = 0.0;
  for (int i = 0; i < 1000; ++i) {
    Matrix6 H = Matrix6::Zero();
    for (std::size_t k = 0; k < most.size(); ++k) H += most[k].transpose() * most[k] / power[k];
    const Vector6 motion = H.completeOrthogonalDecomposition().solve(weight);
    const double work = weight.dot(motion);
    sum = 0.0;
    for (std::size_t k = 0; k < most.size(); ++k) {
      const double now = (most[k] * motion).norm() / work;
      sum += now;
      power[k] = std::max(now, 1e-9);
    }
  }
  return sum;
}

}  // namespace thenar
