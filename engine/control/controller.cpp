// SPDX-License-Identifier: Apache-2.0
#include "engine/control/controller.h"

namespace thenar {

using Eigen::Index;

Controller::Controller(const Model& model)
    : period_s(model.scene.control_period_s),
      f_desired(Eigen::VectorXd::Zero(3 * model.fingers())),
      f_muscle(Eigen::VectorXd::Zero(static_cast<Index>(model.scene.hand.muscles.size()))),
      H(static_cast<Index>(model.scene.hand.joints.size()), f_muscle.size()),
      afference(model),
      search(model),
      compliance(model) {
  most_N.resize(f_muscle.size());
  for (Index m = 0; m < most_N.size(); ++m) most_N[m] = model.scene.hand.muscles[m].max_force_N;
  q_rest = model.scene.posture;
  if (model.scene.muscles_act()) bellies = bellies_of(model.scene.hand);
  if (!model.scene.control) return;
  pid.emplace(model.scene.control->position, model.scene.control->rotation);
  filter.emplace(model);
  if (model.feels()) reflex.emplace(model);
  if (!model.scene.task.phases.empty()) task.emplace(model);
  if (model.scene.chooses_stiffness()) stiffness.emplace(model);
}

GraspProblem grasp_problem(const Scene& scene, const ControlReport& report) {
  const double squeeze_N = report.task.phase < 0 ? scene.control->internal_force_N : report.task.squeeze_N;
  return {.contacts = report.contacts,
          .centre_m = report.centre_m,
          .wrench = report.wrench_desired,
          .friction = scene.control->grasp_friction,
          .cone = scene.control->cone,
          .internal_force_N = squeeze_N + (report.task.holds ? report.stiffness.squeeze_N : 0.0),
          .grips = report.reflex.grips};
}

}  // namespace thenar
