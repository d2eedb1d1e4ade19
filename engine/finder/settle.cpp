// SPDX-License-Identifier: Apache-2.0
#include "engine/finder/settle.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "engine/control/control_tick.h"
#include "engine/finder/pressed_shape.h"
#include "engine/grasp/contact_tick.h"

namespace thenar {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// Moves finger k's pulp by `way_m` with the least joint motion.
void move_pulp(Scene& scene, int k, const Vector3d& way_m) {
  HandPose pose;
  forward_kinematics(scene.hand, scene.posture, pose);
  const Fingertip& tip = scene.hand.fingertips[k];
  const FingerJacobian J = finger_jacobian(scene.hand, pose, k, pose.distal(scene.hand, k) * tip.centre_m);
  Matrix3d JJ = squared(J);
  JJ.diagonal().array() += 1e-4 * JJ.trace();
  const Eigen::VectorXd dq = J.leftCols(tip.joints).transpose() * JJ.ldlt().solve(way_m);
  for (int j = 0; j < tip.joints; ++j) {
    const Joint& joint = scene.hand.joints[tip.first_joint + j];
    double& q = scene.posture[tip.first_joint + j];
    q = std::clamp(q + dq[j], joint.lower_rad, joint.upper_rad);
  }
}

/// Returns the force by which finger k should hold the object at the start.
Vector3d wanted_N(const Model& model, const ControlReport& report, const FingerLoad& load, int k) {
  if (model.scene.control) return report.f_desired.col(k);
  // The one that balances the torques: tau = J' f.
  const Scene& scene = model.scene;
  HandPose pose;
  forward_kinematics(scene.hand, scene.posture, pose);
  const JointVector tau = *scene.torques - gravity_torques(scene.hand, pose, scene.gravity);
  const FingerJacobian J = finger_jacobian(scene.hand, pose, k, load.centre_m);
  Matrix3d JJ = squared(J);
  JJ.diagonal().array() += 1e-9 * JJ.trace();
  return JJ.ldlt().solve(velocity(J, scene.hand.of_finger(k, tau)));
}

/// The error of a finger's load, and its correction.
struct Miss {
  double normal = 0.0, tangential = 0.0;                   ///< As shares of the wanted normal force.
  Vector3d press_m = Vector3d::Zero(), shear_m = press_m;  ///< Ways of the pulp along the normal, and across.
};

Miss miss_of(const Model& model, const ControlReport& report, int k) {
  const FingerLoad& load = (*model.start)[k].load;
  const bool loaded = load.normal_N > 0.0;
  const Vector3d n = loaded ? load.normal : Vector3d(report.contacts[k].axes.col(0));
  const Vector3d wanted = loaded ? wanted_N(model, report, load, k) : n;
  const double normal_N = n.dot(wanted);
  if (n.isZero(0.0) || !(normal_N > 0.0)) return {};
  const Vector3d off = (wanted - load.force_N) / normal_N, across = off - n * n.dot(off);
  // Hertz's F = c d^1.5 about the wanted load: d changes by 2/3 of the share; c_t times that along the surface.
  const Pulp& pulp = model.pulps[k];
  const double depth_m = pressed_depth_m(pulp.material, model.scene.hand.fingertips[k], normal_N);
  const auto bounded = [](double share) { return std::clamp(2.0 / 3.0 * share, -0.5, 0.5); };
  Miss miss{n.dot(off), across.norm()};
  miss.press_m = depth_m * bounded(miss.normal) * n;
  if (loaded) miss.shear_m = depth_m * pulp.tangential * bounded(miss.tangential) * across.normalized();
  return miss;
}

/// Presses the fingers until their loads are the commanded ones; see settle().
double press(Model& model) {
  constexpr int kMostRounds = 24;
  constexpr double kSettled = 2e-3;
  model.start.reset();
  if (!model.deformable()) return 0.0;
  model.start.emplace(model.fingers());
  bool pressed = false;
  for (int round = 0;; ++round) {
    State state(model);
    Controller controller(model);
    Frame frame(model);
    const ControlReport report = control_tick(model, state, controller, frame);
    const PerFinger<FingerLoad> loads = first_loads(model, frame);
    for (int k = 0; k < model.fingers(); ++k) (*model.start)[k].load = loads[k];
    if (round == 0) continue;  // The controller had no loads of the fingers yet.
    PerFinger<Miss> misses(model.fingers());
    double normal = 0.0, tangential = 0.0;
    for (int k = 0; k < model.fingers(); ++k) {
      misses[k] = miss_of(model, report, k);
      normal = std::max(normal, std::abs(misses[k].normal));
      tangential = std::max(tangential, misses[k].tangential);
    }
    // A nearly settled posture is kept: a model made again of its own scene has the same posture.
    const bool press = normal > (pressed ? 1.0 : 2.0) * kSettled, shear = tangential > kSettled;
    if ((!press && !shear) || round == kMostRounds) {
      const bool forces = !model.scene.control || report.grasp == GraspStatus::kOptimal;
      return forces ? std::max(normal, tangential) : 1.0;
    }
    pressed = pressed || press;
    for (int k = 0; k < model.fingers(); ++k) {
      if (press) move_pulp(model.scene, k, misses[k].press_m);
      if (shear) (*model.start)[k].sheared_m += misses[k].shear_m;
    }
  }
}

}  // namespace

double settle(Model& model) {
  // A task that begins with open fingers begins to press only then.
  const std::vector<Phase> phases = std::exchange(model.scene.task.phases, {});
  const double off = press(model);
  model.scene.task.phases = phases;
  return off;
}

}  // namespace thenar
