#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <filesystem>
#include <vector>

#include "bench/cases/scene_run.h"
#include "engine/grasp/scene.h"
#include "engine/scenes/scene_file.h"

namespace thenar::truth {

/// What a probe presses, and how.
struct Probe {
  Shape shape;
  Eigen::Index points = 12000;  ///< Samples of the shape.
  Eigen::Index leaves = 320;    ///< Control points of the pulp; 0: a rigid tip.
  double friction = 0.0;
  double frame_s = 1e-3;      ///< How often contacts are found.
  double relaxation_s = 0.0;  ///< Of the pulp.
  Eigen::Isometry3d X_WO = Eigen::Isometry3d::Identity();
};

inline constexpr double kProbeRadius_m = 8e-3, kProbeModulus_Pa = 0.24e6;

/// A fingertip whose centre stays at the world's origin and that faces along x, and an object that goes where the
/// caller puts it: an experiment under displacement control.
inline Scene scene_of(const Probe& probe) {
  constexpr double kFixed = 1e9;
  Scene scene = load_scene(std::filesystem::path(THENAR_CONFIGS) / "stick.yaml");
  scene.name = "probe";
  scene.task = {};
  scene.task.spring = Spring{1e8, 1e6};
  scene.gravity.setZero();
  scene.control_period_s = probe.frame_s;
  scene.joint_viscosity = kFixed;
  Hand hand;
  hand.joints = {{.name = "fixed",
                  .origin_m = {-0.05, 0.0, 0.0},
                  .axis = Eigen::Vector3d::UnitZ(),
                  .lower_rad = -1.0,
                  .upper_rad = 1.0}};
  Segment segment;
  segment.name = "tip";
  segment.joints = 1;
  segment.X_WS_0.setIdentity();
  hand.segments = {segment};
  Fingertip tip;
  tip.finger = "probe";
  tip.joints = 1;
  tip.centre_m.setZero();
  tip.radius_m = kProbeRadius_m;
  tip.normal = Eigen::Vector3d::UnitX();
  hand.fingertips = {tip};
  scene.hand = hand;
  scene.posture = scene.hand.at_zero();
  scene.torques = scene.hand.at_zero();
  if (probe.leaves > 0) {
    scene.fingertips->points = std::max<Eigen::Index>(2400, probe.leaves);
    scene.fingertips->leaves = probe.leaves;
    scene.fingertips->material.relaxation_s = probe.relaxation_s;
  } else {
    scene.fingertips.reset();
  }
  scene.object.shape = probe.shape;
  scene.object.points = probe.points;
  scene.object.mass_kg = 1e-3;
  scene.object.X_WO = probe.X_WO;
  scene.object.translation_damping = 1.0;
  scene.object.rotation_damping = 1e-3;
  scene.contact.friction = probe.friction;
  scene.contact.max_per_finger = 200;
  scene.contact.tolerance = 1e-9;
  scene.contact.max_sweeps = 2000;
  return scene;
}

/// A loaded contact of the last tick: where the deformed point is, and the force on the object, in the object's frame.
struct LoadedPoint {
  Eigen::Vector3d x_O, f_O;
};

inline std::vector<LoadedPoint> loaded_points(const Model& model, const GraspRun& run) {
  HandPose pose;
  forward_kinematics(model.scene.hand, run.state.q, pose);
  std::vector<LoadedPoint> points;
  const Eigen::Isometry3d X_OW = run.state.X_WO.inverse();
  for (Eigen::Index i = 0; i < run.frame.size(); ++i) {
    const Eigen::Vector3d f = run.work.f.segment<3>(3 * i);
    if (!(f[0] > 0.0)) continue;
    const FrameContact& contact = run.frame.contacts[i];
    const Eigen::Vector3d p_F = contact.p_F - displacement(run.state, contact);
    points.push_back({X_OW * (pose.distal(model.scene.hand, contact.finger) * p_F),
                      X_OW.linear() * (run.work.kinematics.E_W[i] * f)});
  }
  return points;
}

/// Friction and normal force of a point against an outward normal that is known.
struct Split {
  double normal_N, friction_N;
};
inline Split split(const Eigen::Vector3d& f, const Eigen::Vector3d& outward) {
  const double normal_N = -f.dot(outward);
  return {normal_N, (f + normal_N * outward).norm()};
}

}  // namespace thenar::truth
