// SPDX-License-Identifier: Apache-2.0
#include "bench/cases/probe.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "engine/scenes/scene_file.h"

namespace thenar::truth {

using Eigen::Isometry3d;
using Eigen::Vector3d;

Scene scene_of(const Probe& probe) {
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
  if (!probe.half_m.isZero()) {
    tip.shape = PulpShape{.half_m = probe.half_m};
    tip.radius_m = tip.shape->inner_radius_m();
  }
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
  if (probe.object_modulus_Pa > 0.0) {
    scene.object.compliance = PulpMaterial{.reduced_modulus_Pa = probe.object_modulus_Pa, .poisson = 0.4};
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

std::vector<LoadedPoint> loaded_points(const Model& model, const GraspRun& run) {
  HandPose pose;
  forward_kinematics(model.scene.hand, run.state.q, pose);
  std::vector<LoadedPoint> points;
  const Eigen::Isometry3d X_OW = run.state.X_WO.inverse();
  for (Eigen::Index i = 0; i < run.frame.size(); ++i) {
    const Eigen::Vector3d f = run.memory.f.segment<3>(3 * i);
    if (!(f[0] > 0.0)) continue;
    const FrameContact& contact = run.frame.contacts[i];
    const Eigen::Vector3d p_F = contact.p_F - displacement(run.state, contact);
    points.push_back({X_OW * (pose.distal(model.scene.hand, contact.finger) * p_F),
                      X_OW.linear() * (run.work.kinematics.E_W[i] * f)});
  }
  return points;
}

Split split(const Eigen::Vector3d& f, const Eigen::Vector3d& outward) {
  const double normal_N = -f.dot(outward);
  return {normal_N, (f + normal_N * outward).norm()};
}

Surface rod_surface(double radius_m) {
  return [=](const Vector3d& x) -> Over {
    const Vector3d radial(x[0], x[1], 0.0);
    return {radial.normalized(), radial.norm() - radius_m};
  };
}

Surface ring_surface(double ring_m, double rod_m) {
  return [=](const Vector3d& x) -> Over {
    const Vector3d off = x - ring_m * Vector3d(x[0], x[1], 0.0).normalized();
    return {off.normalized(), off.norm() - rod_m};
  };
}

Isometry3d pose_on(const Track& track, double depth_m, double way_m) {
  // Outward is -x of the world, and the way is along its y.
  Eigen::Matrix3d from, to;
  from << track.outward, track.along, track.outward.cross(track.along);
  to << -Vector3d::UnitX(), Vector3d::UnitY(), -Vector3d::UnitZ();
  Isometry3d X = Isometry3d::Identity();
  X.linear() = to * from.transpose();
  X.translation() = (kProbeRadius_m - depth_m) * Vector3d::UnitX() - X.linear() * track.s_m;
  if (track.curvature_per_m == 0.0) return Eigen::Translation3d(0.0, way_m, 0.0) * X;
  const Eigen::Translation3d centre((kProbeRadius_m - depth_m + 1.0 / track.curvature_per_m) * Vector3d::UnitX());
  return centre * Eigen::AngleAxisd(-track.curvature_per_m * way_m, Vector3d::UnitZ()) * centre.inverse() * X;
}

Rubbed slide(const Probe& probe, int ticks, const std::function<Isometry3d(double)>& way, const Surface& surface) {
  constexpr int kLast = 20;
  Loop loop(scene_of(probe));
  Rubbed sum;
  for (int i = 1; i <= ticks; ++i) {
    TickInput input;
    input.X_WT = way(static_cast<double>(i) / ticks);
    const Isometry3d before = loop.state.X_WO;
    loop.tick(input);
    if (i <= ticks - kLast) continue;
    const Isometry3d step = before.inverse() * loop.state.X_WO;
    for (const LoadedPoint& point : loaded_points(loop.model, loop)) {
      const Over over = surface(point.x_O);
      const Split force = split(point.f_O, over.outward);
      sum.least_ratio = std::min(sum.least_ratio, force.friction_N / force.normal_N);
      sum.largest_ratio = std::max(sum.largest_ratio, force.friction_N / force.normal_N);
      const Vector3d moved = step * point.x_O - point.x_O;
      sum.against_N -= point.f_O.dot((moved - moved.dot(over.outward) * over.outward).normalized());
      sum.normal_N += force.normal_N;
      sum.off_m = std::max(sum.off_m, std::abs(over.above_m));
      ++sum.points;
    }
  }
  return sum;
}

Rubbed slide(Probe probe, const Track& track, double way_m, const Surface& surface) {
  constexpr double kDepth_m = 1e-3, kTick_m = 10e-6;
  probe.X_WO = pose_on(track, kDepth_m, 0.0);
  return slide(
      probe, static_cast<int>(std::lround(way_m / kTick_m)),
      [&](double share) { return pose_on(track, kDepth_m, share * way_m); }, surface);
}

}  // namespace thenar::truth
