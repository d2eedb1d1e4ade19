// SPDX-License-Identifier: Apache-2.0
#include "engine/grasp/finger_travel.h"

#include <algorithm>

#include "engine/grasp/pulp_touch.h"
#include "engine/grasp/slides.h"

namespace thenar {

using Eigen::Vector3d;

namespace {

/// The object's free motion in `time_s`: translation, rotation vector.
Vector6d object_motion(const Model& model, const Snapshot& snapshot, const Frame& frame, double time_s) {
  const Scene& scene = model.scene;
  const Spring spring = scene.task.spring.value_or(Spring{});
  Vector6d wrench = frame.wrench;
  for (const FingerLoad& load : snapshot.load) {
    wrench.head<3>() += load.force_N;
    wrench.tail<3>() += (load.centre_m - snapshot.X_WO.translation()).cross(load.force_N);
  }
  if (scene.task.spring) {
    const double end_s = static_cast<double>(snapshot.tick) * scene.step_s + time_s;
    const Vector6d error = pose_error(snapshot.X_WT.value_or(model.target(end_s)), snapshot.X_WO);
    wrench.head<3>() += spring.translation_N_per_m * error.head<3>();
    wrench.tail<3>() += spring.rotation_Nm_per_rad * error.tail<3>();
  }
  wrench.head<3>() *= time_s / (scene.object.translation_damping + time_s * spring.translation_N_per_m);
  wrench.tail<3>() *= time_s / (scene.object.rotation_damping + time_s * spring.rotation_Nm_per_rad);
  return wrench;
}

/// How far the object moves at most against a fingertip that stays, whose centre is at r_m from the object's origin.
[[gnu::noinline]] double object_travel_m(const Fingertip& tip, const Vector3d& r_m, const Vector6d& dx) {
  const Vector3d turn = dx.tail<3>();
  return (dx.head<3>() + turn.cross(r_m)).norm() + outer_radius_m(tip) * turn.norm();
}

}  // namespace

PerFinger<double> finger_travel_m(const Model& model, const HandPose& pose, const Snapshot& snapshot,
                                  const Frame& frame) {
  const Scene& scene = model.scene;
  const double time_s = scene.control_period_s + scene.control_delay_s;
  const Vector6d dx = object_motion(model, snapshot, frame, time_s);
  PerFinger<double> travel(model.fingers()), push(model.fingers());
  for (int k = 0; k < model.fingers(); ++k) {
    const Fingertip& tip = scene.hand.fingertips[k];
    const FingerLoad& load = snapshot.load[k];
    const Vector3d centre_m = pose.distal(scene.hand, k) * tip.centre_m;
    if (scene.hand.slides) {
      push[k] = slide_travel_m(scene, snapshot, frame.torque_Nm, k, time_s);
      travel[k] = push[k] + object_travel_m(tip, centre_m - snapshot.X_WO.translation(), dx);
      continue;
    }
    FingerVector dq = scene.hand.of_finger(k, frame.torque_Nm);
    if (load.normal_N > 0.0) dq -= finger_jacobian(scene.hand, pose, k, load.centre_m).transpose() * load.force_N;
    dq *= time_s / scene.viscosity(k);
    Vector3d turn = -dx.tail<3>();
    if (tip.followers > 0) {
      for (int j = 0; j < tip.joints; ++j) dq[j] /= scene.hand.joints[tip.first_joint + j].drag;
      turn += velocity(turning_axes(scene.hand, pose, k), dq);
    } else {
      for (int j = 0; j < tip.joints; ++j) turn += dq[j] * pose.axis[tip.first_joint + j];
    }
    const Vector3d own = velocity(finger_jacobian(scene.hand, pose, k, centre_m), dq);
    const Vector3d object = dx.head<3>() + dx.tail<3>().cross(centre_m - snapshot.X_WO.translation());
    push[k] = own.norm();
    travel[k] = (own - object).norm() + outer_radius_m(tip) * turn.norm();
  }
  const double most_m = model.object.bounds().diagonal().norm();
  for (int k = 0; k < model.fingers(); ++k) {
    double others_m = 0.0;
    for (int j = 0; j < model.fingers(); ++j) {
      if (j != k) others_m = std::max(others_m, push[j]);
    }
    travel[k] = std::min(most_m, travel[k] + others_m);  // most_m, too, where the drive is not finite
  }
  return travel;
}

}  // namespace thenar
