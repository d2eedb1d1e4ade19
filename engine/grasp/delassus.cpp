#include "engine/grasp/delassus.h"

#include <cmath>

#include "engine/grasp/object_compliance.h"

namespace thenar {

using Eigen::Index;
using Eigen::Vector3d;

namespace {

/// J_c's columns of the fingers times the roots of the joints' mobilities.
void scale_columns(const Hand& hand, const Frame& frame, const JointVector& root, ContactKinematics& kinematics) {
  for (int k = 0; k < hand.fingers(); ++k) {
    const Fingertip& tip = hand.fingertips[k];
    const FingerVector own = hand.of_finger(k, root);
    const Index first = 3 * frame.begin[k], rows = 3 * frame.begin[k + 1] - first;
    kinematics.J_mobile.middleRows(first, rows).noalias() =
        kinematics.J_finger.middleRows(first, rows) * own.head<GroupedDelassus::kOwn>().asDiagonal();
    if (kinematics.J_fifth.size() == 0) continue;
    kinematics.J_fifth_mobile.segment(first, rows) =
        (tip.joints > GroupedDelassus::kOwn ? own[GroupedDelassus::kOwn] : 0.0) *
        kinematics.J_fifth.segment(first, rows);
  }
}

}  // namespace

Mobility mobility(const Scene& scene, double joint_stiffness) {
  const double h = scene.step_s;
  const Spring spring = scene.task.spring.value_or(Spring{});
  Mobility all{h / (scene.joint_viscosity + h * joint_stiffness),
               h / (scene.object.translation_damping + h * spring.translation_N_per_m),
               h / (scene.object.rotation_damping + h * spring.rotation_Nm_per_rad)};
  for (const Fingertip& tip : scene.hand.fingertips) {
    if (!tip.joint_viscosity && tip.followers == 0) continue;
    if (all.root.size() == 0) all.root.setOnes(std::ssize(scene.hand.joints));
    const double b = tip.joint_viscosity.value_or(scene.joint_viscosity);
    const double own = h / (b + h * joint_stiffness);
    all.root.segment(tip.first_joint, tip.joints).setConstant(std::sqrt(own / all.joint));
    for (int j = tip.first_joint; tip.followers > 0 && j < tip.first_joint + tip.joints; ++j) {
      all.root[j] = std::sqrt(h / (b * scene.hand.joints[j].drag + h * joint_stiffness) / all.joint);
    }
  }
  return all;
}

void set_shares(const Model& model, const Frame& frame, const Mobility& mobility, ContactKinematics& kinematics) {
  if (mobility.root.size() > 0) scale_columns(model.scene.hand, frame, mobility.root, kinematics);
  for (std::size_t k = 0; k < kinematics.pulp_share.size(); ++k) {
    const auto gained = [&](const Pulp& pulp) { return 1.0 - retained_share(pulp.material, model.scene.step_s); };
    kinematics.pulp_share[k] = gained(model.pulps[k]) / gained(model.pulps.front());
  }
}

GroupedDelassus delassus_operator(const Model& model, const Frame& frame, const ContactKinematics& kinematics,
                                  const Mobility& mobility) {
  const bool alike = mobility.root.size() == 0;
  GroupedDelassus W{.begin = frame.begin,
                    .J_own = alike ? kinematics.J_finger : kinematics.J_mobile,
                    .J_fifth = alike ? kinematics.J_fifth : kinematics.J_fifth_mobile,
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
    W.group_scale = {kinematics.pulp_share.data(), kinematics.pulp_share.size()};
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

void add_joint_motion(const Hand& hand, const Mobility& mobility, const GroupedWorkspace& solve, JointVector& dq) {
  for (int k = 0; k < hand.fingers(); ++k) {
    const Fingertip& tip = hand.fingertips[k];
    for (int c = 0; c < tip.joints; ++c) {
      const int j = tip.first_joint + c;
      dq[j] += mobility.root.size() == 0 ? solve.own_motion(c, k) : mobility.root[j] * solve.own_motion(c, k);
    }
  }
}

}  // namespace thenar
