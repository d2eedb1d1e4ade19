#include "engine/delassus.h"

namespace thenar {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

namespace {

Matrix3d skew(const Vector3d& v) {
  Matrix3d S;
  S << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return S;
}

}  // namespace

ContactJacobian::ContactJacobian(const Model& model)
    : finger(3 * model.max_contacts, kJointsPerFinger),
      object(3 * model.max_contacts, 6),
      E_W(model.max_contacts),
      c_O(model.max_contacts) {}

void fill_jacobian(const Model& model, const Frame& frame, const HandPose& pose, const State& state,
                   ContactJacobian& jacobian) {
  for (int k = 0; k < kFingers; ++k) {
    const Isometry3d& X_WF = pose.distal(model.scene.hand, k);
    const Isometry3d X_FO = X_WF.inverse() * state.X_WO;
    for (Index i = frame.begin[k]; i < frame.begin[k + 1]; ++i) {
      const FrameContact& contact = frame.contacts[i];
      const Vector3d u_F = displacement(state, contact);
      const Matrix3d E_W = axes_of(X_WF.linear() * contact.E_F.col(0), X_WF.linear() * contact.E_F.col(1));
      const Vector3d c_W = X_WF * (contact.p_F - u_F + contact_gap(contact, X_FO, u_F) * contact.E_F.col(0));
      jacobian.E_W[i] = E_W;
      jacobian.c_O[i] = state.X_WO.inverse() * c_W;
      jacobian.finger.middleRows<3>(3 * i) = -E_W.transpose() * finger_jacobian(pose, k, c_W);
      jacobian.object.block<3, 3>(3 * i, 0) = E_W.transpose();
      jacobian.object.block<3, 3>(3 * i, 3) = -E_W.transpose() * skew(c_W - state.X_WO.translation());
    }
  }
}

Mobility mobility(const Scene& scene, double joint_stiffness) {
  const double h = scene.step_s;
  const Spring spring = scene.task.spring.value_or(Spring{});
  return {h / (scene.joint_viscosity + h * joint_stiffness),
          h / (scene.object.translation_damping + h * spring.translation_N_per_m),
          h / (scene.object.rotation_damping + h * spring.rotation_Nm_per_rad)};
}

void assemble_delassus(const Model& model, const Frame& frame, const ContactJacobian& jacobian,
                       const Mobility& mobility, Eigen::Ref<MatrixXd> W) {
  const double h = model.scene.step_s;
  const auto J_o = jacobian.object.topRows(3 * frame.size());
  W.noalias() = mobility.translation * J_o.leftCols<3>() * J_o.leftCols<3>().transpose();
  W.noalias() += mobility.rotation * J_o.rightCols<3>() * J_o.rightCols<3>().transpose();
  for (int k = 0; k < kFingers; ++k) {
    const Index first = 3 * frame.begin[k], rows = 3 * frame.begin[k + 1] - first;
    if (rows == 0) continue;
    auto W_k = W.block(first, first, rows, rows);
    const auto J_k = jacobian.finger.middleRows(first, rows);
    W_k.noalias() += mobility.joint * J_k * J_k.transpose();
    if (!model.deformable()) continue;
    W_k += (1.0 - memory(model.pulps[k].material, h)) * frame.compliance[k].topLeftCorner(rows, rows);
  }
}

}  // namespace thenar
