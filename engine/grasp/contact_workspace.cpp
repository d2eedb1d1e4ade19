#include "engine/grasp/contact_workspace.h"

namespace thenar {

FramePolicy split_policy(const Scene& scene) {
  FramePolicy policy;
  policy.offset_decay_s = scene.control_period_s;
  if (scene.control) policy.hold_after_s = 3.0 * scene.control_period_s + scene.control_delay_s;
  return policy;
}

namespace {

EnvironmentContacts environment_of(const Model& model) {
  if (!model.scene.environment) return {};
  const std::optional<Solid> exact = solid_of(model.scene.object.shape);
  if (!exact && !model.sampled) return {};
  return {*model.scene.environment, exact ? TouchingSolid(*exact) : TouchingSolid(model.sampled)};
}

}  // namespace

ContactWorkspace::ContactWorkspace(const Model& model, const FramePolicy& frame_policy)
    : policy(frame_policy),
      kinematics(model),
      offset_m(Eigen::VectorXd::Zero(model.max_contacts)),
      old_offset_m(Eigen::VectorXd::Zero(model.max_contacts)),
      delta_free(3 * model.max_contacts),
      delta(3 * model.max_contacts),
      f(3 * model.max_contacts),
      mu(Eigen::VectorXd::Constant(model.max_contacts, model.scene.contact.friction)),
      f_first(3 * model.max_contacts),
      environment(environment_of(model)),
      environment_again(environment_of(model)),
      solver(model.max_contacts, model.fingers(), model.soft_object(), static_cast<Eigen::Index>(environment.most())),
      torque_Nm(model.scene.hand.at_zero()),
      resumed_Nm(model.scene.hand.at_zero()),
      q_held(model.scene.hand.at_zero()),
      torque_held_Nm(model.scene.hand.at_zero()),
      loads(model),
      patches(model) {
  if (model.feels()) {
    touch_noise.share = model.scene.fingertips->touch->noise;
    touch_noise.random.seed(model.scene.fingertips->touch->seed);
  }
  contacts.reserve(model.max_contacts);
  pose.segments.resize(model.scene.hand.segments.size());
  pose.q = JointVector::Constant(q_held.size(), std::numeric_limits<double>::quiet_NaN());
}

}  // namespace thenar
