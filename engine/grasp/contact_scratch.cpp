// SPDX-License-Identifier: Apache-2.0
#include "engine/grasp/contact_scratch.h"

#include <limits>

namespace thenar {

EnvironmentContacts environment_of(const Model& model) {
  if (!model.scene.environment) return {};
  const std::optional<Solid> exact = solid_of(model.scene.object.shape);
  if (!exact && !model.sampled) return {};
  return {*model.scene.environment, exact ? TouchingSolid(*exact) : TouchingSolid(model.sampled)};
}

ContactScratch::ContactScratch(const Model& model)
    : kinematics(model),
      old_offset_m(Eigen::VectorXd::Zero(model.max_contacts)),
      old_change_N(Eigen::MatrixX2d::Zero(3 * model.max_contacts, 2)),
      delta_free(3 * model.max_contacts),
      delta(3 * model.max_contacts),
      mu(Eigen::VectorXd::Constant(model.max_contacts, model.scene.contact.friction)),
      f_then(3 * model.max_contacts),
      f_first(3 * model.max_contacts),
      environment(environment_of(model)),
      environment_again(environment_of(model)),
      loads(model),
      patches(model) {
  if (model.scene.muscles_act()) bellies.resize(bellies_of(model.scene.hand).size());
  pose.segments.resize(model.scene.hand.segments.size());
  pose.q = JointVector::Constant(std::ssize(model.scene.hand.joints), std::numeric_limits<double>::quiet_NaN());
}

}  // namespace thenar
