#include "engine/finder/settle.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "engine/grasp/contact_tick.h"
#include "engine/grasp/control_tick.h"
#include "engine/grasp/pulp_touch.h"

namespace thenar {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// Moves finger k's pulp by `way_m` without its joints moving more than they must.
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

/// The normal force that finger k is to press with at the start.
double wanted_N(const Model& model, const ControlReport& report, const FingerLoad& load, int k) {
  if (model.scene.control) return load.normal.dot(report.f_desired.col(k));
  // Those that balance the torques: tau = J' f.
  const Scene& scene = model.scene;
  HandPose pose;
  forward_kinematics(scene.hand, scene.posture, pose);
  const JointVector tau = *scene.torques - gravity_torques(scene.hand, pose, scene.gravity);
  const FingerJacobian J = finger_jacobian(scene.hand, pose, k, load.centre_m);
  Matrix3d JJ = squared(J);
  JJ.diagonal().array() += 1e-9 * JJ.trace();
  const Vector3d f = JJ.ldlt().solve(velocity(J, scene.hand.of_finger(k, tau)));
  return load.normal.dot(f);
}

}  // namespace

double settle(Model& model) {
  constexpr int kMostRounds = 13;
  constexpr double kSettled = 5e-3;
  model.start_load.reset();
  if (!model.deformable()) return 0.0;
  double worst = 0.0;
  for (int round = 0; round < kMostRounds; ++round) {
    State state(model);
    Controller controller(model);
    Frame frame(model);
    ContactWorkspace work(model);
    const ControlReport report = control_tick(model, state, controller, frame);
    (void)contact_tick(model, frame, work, state);
    const bool knows_loads = model.start_load.has_value();
    model.start_load = state.load;
    if (!knows_loads) continue;  // The first time the controller asked without knowing what the fingers carry.
    worst = 0.0;
    const JointVector before = model.scene.posture;
    for (int k = 0; k < model.fingers(); ++k) {
      const FingerLoad& load = state.load[k];
      const Vector3d n = load.normal_N > 0.0 ? load.normal : report.contacts[k].axes.col(0);
      if (n.isZero(0.0)) continue;
      const double wanted = load.normal_N > 0.0 ? wanted_N(model, report, load, k) : 1.0;
      if (!(wanted > 0.0)) continue;
      const double miss = 1.0 - load.normal_N / wanted;
      worst = std::max(worst, std::abs(miss));
      // Hertz's F = c d^1.5 about the wanted load: d changes by 2/3 of the share.
      const Pulp& pulp = model.pulps[k];
      const Fingertip& tip = model.scene.hand.fingertips[k];
      const double E_Pa = pulp.material.reduced_modulus_Pa / softness(pulp.material, wanted);
      const double depth_m = std::pow(0.75 * wanted / (E_Pa * std::sqrt(round_radius_m(tip))), 2.0 / 3.0);
      move_pulp(model.scene, k, n * std::clamp(2.0 / 3.0 * miss, -0.5, 0.5) * depth_m);
    }
    // What is nearly settled stays: a model that is made again of its own scene has the same posture.
    if (worst < (round == 1 ? 2.0 : 1.0) * kSettled) {
      model.scene.posture = before;
      break;
    }
  }
  return worst;
}

}  // namespace thenar
