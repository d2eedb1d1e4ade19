#include "engine/grasp/delassus.h"

#include "engine/grasp/object_compliance.h"

namespace thenar {

using Eigen::Index;
using Eigen::Vector3d;

Mobility mobility(const Scene& scene, double joint_stiffness) {
  const double h = scene.step_s;
  const Spring spring = scene.task.spring.value_or(Spring{});
  return {h / (scene.joint_viscosity + h * joint_stiffness),
          h / (scene.object.translation_damping + h * spring.translation_N_per_m),
          h / (scene.object.rotation_damping + h * spring.rotation_Nm_per_rad)};
}

GroupedDelassus delassus_operator(const Model& model, const Frame& frame, const ContactKinematics& kinematics,
                                  const Mobility& mobility) {
  GroupedDelassus W{.begin = frame.begin,
                    .J_own = kinematics.J_finger,
                    .J_fifth = kinematics.J_fifth,
                    .J_common = kinematics.J_object,
                    .own_mobility = mobility.joint,
                    .common_mobility = {},
                    .compliance = {},
                    .axes = kinematics.pulp_axes};
  W.common_mobility << Vector3d::Constant(mobility.translation), Vector3d::Constant(mobility.rotation), 0.0, 0.0;
  if (model.deformable()) {
    W.compliance = frame.compliance;
    W.edition = frame.sequence;
    W.compliance_scale = 1.0 - retained_share(model.pulps.front().material, model.scene.step_s);
    W.common_compliance = object_compliance(model, frame, kinematics.object_tensors);
  }
  return W;
}

Eigen::MatrixXd dense_delassus(const Model& model, const Frame& frame, const ContactKinematics& kinematics,
                               const Mobility& mobility) {
  const Index rows = 3 * frame.size();
  Eigen::MatrixXd W(rows, rows);
  delassus_operator(model, frame, kinematics, mobility).to_dense(W);
  return W;
}

void add_joint_motion(const Hand& hand, const GroupedWorkspace& solve, JointVector& dq) {
  for (int k = 0; k < hand.fingers(); ++k) {
    const Fingertip& tip = hand.fingertips[k];
    dq.segment(tip.first_joint, tip.joints) += solve.own_motion.col(k).head(tip.joints);
  }
}

}  // namespace thenar
