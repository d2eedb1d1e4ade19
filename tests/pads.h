#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <numbers>
#include <utility>

#include "tests/scenes.h"

namespace thenar {

/// Three pads of radius 8 mm that press on an object with constant forces, each free to move along its normal alone: a
/// grasp whose limits can be worked out by hand. Nobody controls it.
struct Pads {
  Shape shape = SphereShape{25e-3};
  std::array<Eigen::Vector3d, kFingers> at_m;     ///< Where each first touches the surface, object frame.
  std::array<Eigen::Vector3d, kFingers> inward;   ///< Unit; the direction that it presses in.
  std::array<double, kFingers> force_N{2.0, 2.0, 2.0};
  double depth_m = 0.8e-3;  ///< How deep the rest shapes are pressed in at the start.
  Eigen::Vector3d gravity{0.0, 0.0, -9.81};
  double mass_kg = 0.1;
  double friction = 0.8;
};

/// Pads at 120 degrees round the z axis, on a surface whose radius there is `radius_m`.
inline Pads pads_round(const Shape& shape, double radius_m) {
  Pads pads;
  pads.shape = shape;
  for (int k = 0; k < kFingers; ++k) {
    const double angle = 2.0 * std::numbers::pi / kFingers * k;
    const Eigen::Vector3d outward(std::cos(angle), std::sin(angle), 0.0);
    pads.at_m[k] = radius_m * outward;
    pads.inward[k] = -outward;
  }
  return pads;
}

/// A pad against two of half its force, `apart_m` from one another along z: a pinch across x of an object `width_m` wide.
inline Pads pads_across(const Shape& shape, double width_m, double apart_m) {
  Pads pads;
  pads.shape = shape;
  pads.at_m = {Eigen::Vector3d(-0.5 * width_m, 0.0, 0.0), Eigen::Vector3d(0.5 * width_m, 0.0, 0.5 * apart_m),
               Eigen::Vector3d(0.5 * width_m, 0.0, -0.5 * apart_m)};
  pads.inward = {Eigen::Vector3d::UnitX(), -Eigen::Vector3d::UnitX(), -Eigen::Vector3d::UnitX()};
  pads.force_N = {2.0, 1.0, 1.0};
  return pads;
}

/// The scene of it. A finger's four joints turn together about an axis a metre away, so that its pad moves along its
/// normal, to 1e-6 of the way for each micrometre; each joint has the torque that the force asks for.
inline Scene scene_of(const Pads& pads) {
  constexpr double kArm_m = 1.0;
  Scene scene = scene_of("stick");
  scene.name = "pads";
  scene.task = {};
  scene.gravity = pads.gravity;
  scene.contact.friction = pads.friction;
  scene.control_period_s = scene.step_s;
  scene.object.shape = pads.shape;
  scene.object.points = 6000;
  scene.object.mass_kg = pads.mass_kg;
  scene.object.X_WO.setIdentity();
  scene.joint_viscosity = 40.0;  // 10 N s/m at the pad
  scene.posture.setZero();
  JointVector torques;
  for (Segment& segment : scene.hand.segments) segment.mass_kg = 0.0;
  for (int k = 0; k < kFingers; ++k) {
    Fingertip& tip = scene.hand.fingertips[k];
    tip.radius_m = 8e-3;
    tip.centre_m.setZero();
    Segment& segment = scene.hand.segments[tip.segment];
    segment.X_WS_0.linear() = Eigen::Quaterniond::FromTwoVectors(tip.normal, pads.inward[k]).toRotationMatrix();
    segment.X_WS_0.translation() = pads.at_m[k] - (tip.radius_m - pads.depth_m) * pads.inward[k];
    const Eigen::Vector3d axis = pads.inward[k].unitOrthogonal();
    for (int j = 0; j < kJointsPerFinger; ++j) {
      Joint& joint = scene.hand.joints[kJointsPerFinger * k + j];
      joint.axis = axis;
      joint.origin_m = segment.X_WS_0.translation() + kArm_m * axis.cross(pads.inward[k]);
      torques[kJointsPerFinger * k + j] = kArm_m * pads.force_N[k];
    }
  }
  scene.torques = torques;
  return scene;
}

}  // namespace thenar
