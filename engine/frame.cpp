#include "engine/frame.h"

namespace thenar {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

namespace {

// A pulp pressed deeper than half its radius is beyond any law used here; the search need not go further.
constexpr double kReachPerRadius = 0.5;

Matrix3d skew(const Vector3d& v) {
  Matrix3d S;
  S << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return S;
}

void add_contact(const Model& model, const HandPose& pose, const Isometry3d& X_WO, int finger, Index control_point,
                 const Vector3d& p_F, const Vector3d& s_O, const Vector3d& n_O, Frame& frame) {
  const Fingertip& tip = model.scene.hand.fingertips[finger];
  const Matrix3d& R_WF = pose.distal(model.scene.hand, finger).linear();
  const Matrix3d E_W = contact_frame(R_WF, tip.normal, X_WO.linear() * n_O);
  frame.contacts.push_back({finger, control_point, p_F, s_O, n_O, 0.0, E_W, R_WF.transpose() * E_W});
}

void find_pulp_contacts(const Model& model, const HandPose& pose, const Isometry3d& X_WO, int finger,
                        std::vector<ContactCandidate>& candidates, Frame& frame) {
  const Pulp& pulp = model.pulps[finger];
  const ContactSettings& contact = model.scene.contact;
  const double reach_m = kReachPerRadius * model.scene.hand.fingertips[finger].radius_m;
  const Isometry3d X_OF = X_WO.inverse() * pose.distal(model.scene.hand, finger);
  find_contacts(pulp.surface, pulp.tree, X_OF, model.object, {contact.band_m, reach_m, contact.max_per_finger},
                candidates);
  for (const ContactCandidate& c : candidates) {
    add_contact(model, pose, X_WO, finger, c.control_point, pulp.control_points_m.col(c.control_point), c.point_m,
                -c.normal, frame);
  }
}

void find_point_contact(const Model& model, const HandPose& pose, const Isometry3d& X_WO, int finger, Frame& frame) {
  const Fingertip& tip = model.scene.hand.fingertips[finger];
  const Isometry3d X_OF = X_WO.inverse() * pose.distal(model.scene.hand, finger);
  const double band_m = model.scene.contact.band_m;
  const double reach_m = tip.radius_m + band_m + model.object.support_m();
  const auto nearest = model.object.distance(X_OF * tip.centre_m, reach_m);
  if (!nearest || nearest->distance_m - tip.radius_m >= band_m) return;
  const Vector3d n_F = X_OF.linear().transpose() * -nearest->normal;
  add_contact(model, pose, X_WO, finger, 0, tip.centre_m + tip.radius_m * n_F, nearest->point_m, -nearest->normal,
              frame);
}

}  // namespace

Matrix3d contact_frame(const Matrix3d& R_WF, const Vector3d& pulp_normal, const Vector3d& n_W) {
  const auto carry = Eigen::Quaterniond::FromTwoVectors(pulp_normal, R_WF.transpose() * n_W);
  const Vector3d t1 = R_WF * (carry * pulp_normal.unitOrthogonal());
  Matrix3d E_W;
  E_W.col(0) = n_W;
  // A hand file's rotations are rounded; the frame is orthonormal all the same.
  E_W.col(1) = (t1 - t1.dot(n_W) * n_W).normalized();
  E_W.col(2) = n_W.cross(E_W.col(1));
  return E_W;
}

Frame::Frame(const Model& model)
    : J_finger(3 * model.max_contacts, kJointsPerFinger), J_object(3 * model.max_contacts, 6) {
  contacts.reserve(model.max_contacts);
  const Index per_finger = model.deformable() ? model.max_contacts / kFingers : 0;
  for (MatrixXd& C : compliance) C.setZero(3 * per_finger, 3 * per_finger);
  X_WO.setIdentity();
  X_WF.fill(Isometry3d::Identity());
  torque_Nm.setZero();
  wrench.setZero();
}

void find_frame_contacts(const Model& model, const HandPose& pose, const Isometry3d& X_WO,
                         std::vector<ContactCandidate>& candidates, Frame& frame) {
  frame.contacts.clear();
  for (int k = 0; k < kFingers; ++k) {
    frame.begin[k] = frame.size();
    if (model.deformable()) {
      find_pulp_contacts(model, pose, X_WO, k, candidates, frame);
    } else {
      find_point_contact(model, pose, X_WO, k, frame);
    }
  }
  frame.begin[kFingers] = frame.size();
}

void fill_factors(const Model& model, const HandPose& pose, const Isometry3d& X_WO, Frame& frame) {
  for (Index i = 0; i < frame.size(); ++i) {
    const FrameContact& contact = frame.contacts[i];
    const Vector3d s_W = X_WO * contact.s_O;
    frame.J_finger.middleRows<3>(3 * i) = -contact.E_W.transpose() * finger_jacobian(pose, contact.finger, s_W);
    frame.J_object.block<3, 3>(3 * i, 0) = contact.E_W.transpose();
    frame.J_object.block<3, 3>(3 * i, 3) = -contact.E_W.transpose() * skew(s_W - X_WO.translation());
  }
  if (!model.deformable()) return;
  for (int k = 0; k < kFingers; ++k) {
    const Pulp& pulp = model.pulps[k];
    const Vector3d S(1.0, pulp.tangential, pulp.tangential);
    for (Index j = frame.begin[k]; j < frame.begin[k + 1]; ++j) {
      const FrameContact& cj = frame.contacts[j];
      const Matrix3d E_j_S = cj.E_F * S.asDiagonal();
      for (Index i = frame.begin[k]; i <= j; ++i) {
        const FrameContact& ci = frame.contacts[i];
        const Matrix3d C_ij =
            pulp.kernel(ci.control_point, cj.control_point) * (S.asDiagonal() * (ci.E_F.transpose() * E_j_S));
        const Index row = 3 * (i - frame.begin[k]), column = 3 * (j - frame.begin[k]);
        frame.compliance[k].block<3, 3>(row, column) = C_ij;
        frame.compliance[k].block<3, 3>(column, row) = C_ij.transpose();
      }
    }
  }
}

void assemble_delassus(const Model& model, const Frame& frame, Eigen::Ref<MatrixXd> W) {
  const Scene& scene = model.scene;
  const double h = scene.step_s;
  const auto J_o = frame.J_object.topRows(3 * frame.size());
  W.noalias() = (h / scene.object.translation_damping) * J_o.leftCols<3>() * J_o.leftCols<3>().transpose();
  W.noalias() += (h / scene.object.rotation_damping) * J_o.rightCols<3>() * J_o.rightCols<3>().transpose();
  for (int k = 0; k < kFingers; ++k) {
    const Index first = 3 * frame.begin[k], rows = 3 * frame.begin[k + 1] - first;
    if (rows == 0) continue;
    auto W_k = W.block(first, first, rows, rows);
    const auto J_k = frame.J_finger.middleRows(first, rows);
    W_k.noalias() += (h / scene.joint_viscosity) * J_k * J_k.transpose();
    if (!model.deformable()) continue;
    W_k += (1.0 - memory(model.pulps[k].material, h)) * frame.compliance[k].topLeftCorner(rows, rows);
  }
}

}  // namespace thenar
