// SPDX-License-Identifier: Apache-2.0
#include "engine/grasp/state.h"

namespace thenar {

Vector6d pose_error(const Eigen::Isometry3d& X_WT, const Eigen::Isometry3d& X_WO) {
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(X_WT.linear() * X_WO.linear().transpose()));
  Vector6d error;
  error << X_WT.translation() - X_WO.translation(), turn.angle() * turn.axis();
  return error;
}

State::State(const Model& model) {
  q = model.scene.posture;
  load = PerFinger<FingerLoad>(model.fingers());
  for (int k = 0; k < model.fingers() && model.start; ++k) load[k] = (*model.start)[k].load;
  if (model.scene.has_muscles()) pull_N.setZero(std::ssize(model.scene.hand.muscles));
  if (model.feels()) touch = PerFinger<Touch>(model.fingers());
  pulp_energy_J = PerFinger<double>(model.fingers());
  X_WO = model.scene.object.X_WO;
  for (const Pulp& pulp : model.pulps) u_m.emplace_back(Eigen::MatrixX3d::Zero(pulp.controls(), 3));
  forces.reserve(model.max_contacts);
  if (model.scene.chooses_stiffness()) contact_forces.assign(model.max_contacts, {kMaxFingers, 0, {}});
  if (model.soft_object()) object_loads.reserve(kLoadsPerContact * model.max_contacts);
}

}  // namespace thenar
