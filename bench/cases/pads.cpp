#include "bench/cases/pads.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include "bench/cases/scene_run.h"
#include "engine/grasp/scene.h"
#include "engine/scenes/scene_file.h"

namespace thenar {

Pads pads_round(const Shape& shape, double radius_m) {
  Pads pads;
  pads.shape = shape;
  pads.curvature_per_m = 1.0 / radius_m;
  for (int k = 0; k < kPads; ++k) {
    const double angle = 2.0 * std::numbers::pi / kPads * k;
    const Eigen::Vector3d outward(std::cos(angle), std::sin(angle), 0.0);
    pads.at_m[k] = radius_m * outward;
    pads.inward[k] = -outward;
  }
  return pads;
}

Pads pads_across(const Shape& shape, double width_m, double apart_m) {
  Pads pads;
  pads.shape = shape;
  pads.at_m = {Eigen::Vector3d(-0.5 * width_m, 0.0, 0.0), Eigen::Vector3d(0.5 * width_m, 0.0, 0.5 * apart_m),
               Eigen::Vector3d(0.5 * width_m, 0.0, -0.5 * apart_m)};
  pads.inward = {Eigen::Vector3d::UnitX(), -Eigen::Vector3d::UnitX(), -Eigen::Vector3d::UnitX()};
  pads.force_N = {2.0, 1.0, 1.0};
  return pads;
}

Scene scene_of(const Pads& pads) {
  constexpr double kArm_m = 1.0;
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
  scene.joint_viscosity = 40.0;  // 10 N s/m at the pad
  scene.posture.setZero();
  JointVector torques = scene.hand.at_zero();
  for (Segment& segment : scene.hand.segments) segment.mass_kg = 0.0;
  for (int k = 0; k < kPads; ++k) {
    Fingertip& tip = scene.hand.fingertips[k];
    tip.radius_m = 8e-3;
    tip.centre_m.setZero();
    Segment& segment = scene.hand.segments[tip.segment];
    segment.X_WS_0.linear() = Eigen::Quaterniond::FromTwoVectors(tip.normal, pads.inward[k]).toRotationMatrix();
    segment.X_WS_0.translation() = pads.at_m[k] - (tip.radius_m - pads.depth_m) * pads.inward[k];
    const Eigen::Vector3d axis = pads.inward[k].unitOrthogonal();
    for (int j = tip.first_joint; j < tip.first_joint + tip.joints; ++j) {
      Joint& joint = scene.hand.joints[j];
      joint.axis = axis;
      joint.origin_m = segment.X_WS_0.translation() + kArm_m * axis.cross(pads.inward[k]);
      joint.lower_rad = -1.0, joint.upper_rad = 1.0;
      torques[j] = kArm_m * pads.force_N[k];
    }
  }
  scene.torques = torques;
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

double most_mass_kg(const Pads& pads, double reduced_modulus_Pa, double pad_radius_m) {
  // Of a motion: velocity of the origin, rotation; of a load: force, moment.
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  // What a pad can do, by motions along its two tangents and turns.
  std::array<Eigen::Matrix<double, 3, 6>, kPads> most;
  for (int k = 0; k < kPads; ++k) {
    const Eigen::Vector3d n = pads.inward[k], t = n.unitOrthogonal();
    const double friction_N = pads.friction * pads.force_N[k];
    const double a_m =
        std::cbrt(0.75 * pads.force_N[k] / (reduced_modulus_Pa * (1.0 / pad_radius_m + pads.curvature_per_m)));
    const auto row = [&](int r, const Eigen::Vector3d& axis) {
      most[k].row(r) << friction_N * axis.transpose(), friction_N * pads.at_m[k].cross(axis).transpose();
    };
    row(0, t);
    row(1, n.cross(t));
    most[k].row(2) << Eigen::RowVector3d::Zero(), 3.0 * std::numbers::pi / 16.0 * friction_N * a_m * n.transpose();
  }
  Vector6 weight;
  weight << pads.gravity, pads.centre_of_mass_m.cross(pads.gravity);
  std::array<double, kPads> power{1.0, 1.0, 1.0};
  double sum = 0.0;
  for (int i = 0; i < 1000; ++i) {
    Matrix6 H = Matrix6::Zero();
    for (int k = 0; k < kPads; ++k) H += most[k].transpose() * most[k] / power[k];
    const Vector6 motion = H.completeOrthogonalDecomposition().solve(weight);
    const double work = weight.dot(motion);
    sum = 0.0;
    for (int k = 0; k < kPads; ++k) {
      const double now = (most[k] * motion).norm() / work;
      sum += now;
      power[k] = std::max(now, 1e-9);
    }
  }
  return sum;
}

}  // namespace thenar
