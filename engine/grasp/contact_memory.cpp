// SPDX-License-Identifier: Apache-2.0
#include "engine/grasp/contact_memory.h"

#include "engine/grasp/contact_scratch.h"

namespace thenar {

FramePolicy split_policy(const Scene& scene) {
  FramePolicy policy;
  policy.offset_decay_s = scene.control_period_s;
  if (scene.control) policy.hold_after_s = 3.0 * scene.control_period_s + scene.control_delay_s;
  return policy;
}

ContactMemory::ContactMemory(const Model& model, const FramePolicy& frame_policy)
    : policy(frame_policy),
      offset_m(Eigen::VectorXd::Zero(model.max_contacts)),
      f(Eigen::VectorXd::Zero(3 * model.max_contacts)),
      change_N(Eigen::MatrixX2d::Zero(3 * model.max_contacts, 2)),
      torque_Nm(model.scene.hand.at_zero()),
      resumed_Nm(model.scene.hand.at_zero()),
      q_held(model.scene.hand.at_zero()),
      torque_held_Nm(model.scene.hand.at_zero()),
      solver(model.max_contacts, model.fingers(), model.soft_object(),
             static_cast<Eigen::Index>(environment_of(model).most())) {
  if (model.feels()) {
    touch_noise.share = model.scene.fingertips->touch->noise;
    touch_noise.random.seed(model.scene.fingertips->touch->seed);
  }
  contacts.reserve(model.max_contacts);
}

void reserve(const Model& model, std::size_t environment_contacts, State& state, ContactMemory& memory) {
  state.forces.reserve(model.max_contacts);
  if (model.soft_object()) state.object_loads.reserve(kLoadsPerContact * model.max_contacts);
  state.environment_forces.reserve(environment_contacts);
  memory.contacts.reserve(model.max_contacts);
}

}  // namespace thenar
