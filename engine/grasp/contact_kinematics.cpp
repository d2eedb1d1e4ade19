#include "engine/grasp/contact_kinematics.h"

#include <algorithm>
#include <cmath>

#include "engine/grasp/object_compliance.h"

namespace thenar {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

ContactKinematics::ContactKinematics(const Model& model)
    : X_WO(model.scene.object.X_WO),
      X_FO(model.fingers(), Isometry3d::Identity()),
      points(model.max_contacts),
      gap_m(model.max_contacts),
      gap_unit(model.max_contacts),
      J_finger(3 * model.max_contacts, 4),
      J_mobile(3 * model.max_contacts, 4),
      J_object(GroupedDelassus::CommonJacobian::Zero(3 * model.max_contacts, GroupedDelassus::kPadded)),
      E_W(model.max_contacts),
      E_F(model.max_contacts),
      c_W(model.max_contacts) {
  const auto& tips = model.scene.hand.fingertips;
  if (std::any_of(tips.begin(), tips.end(), [](const Fingertip& tip) { return tip.joints > 4; })) {
    J_fifth.setZero(3 * model.max_contacts);
    J_fifth_mobile = J_fifth;
  }
  if (model.deformable()) pulp_axes.setZero(3 * model.max_contacts, 3);
  if (std::any_of(model.pulps.begin(), model.pulps.end(), [&](const Pulp& pulp) {
        return pulp.material.relaxation_s != model.pulps.front().material.relaxation_s;
      })) {
    pulp_share = PerFinger<double>(model.fingers());
  }
  if (!model.soft_object()) return;
  E_O.resize(model.max_contacts);
  object_tensors.setZero(3 * model.max_contacts, 3);
  u_O.setZero(model.max_contacts, 3);
  u_object_m.setZero(3, model.max_contacts);
}

namespace {

/// The normal force on a contact in the tick before.
double last_normal_N(const State& state, const FrameContact& contact) {
  const auto last = std::ranges::lower_bound(state.forces, id_of(contact), {}, [](const auto& f) { return id_of(f); });
  return last != state.forces.end() && id_of(*last) == id_of(contact) ? last->f_C[0] : 0.0;
}

/// The axes of a contact in the distal frame: those of its gap and slips, and those of the pulp's and the object's u.
/// They are all one, but of a contact that fades.
struct ContactAxes {
  Matrix3d of_gap, of_pulp, of_object;
};

/// E turned by the least angle that takes its first column, of length one, to n. Opposite ones it leaves finite.
Matrix3d turned(const Matrix3d& E, const Vector3d& n) {
  const Vector3d axis = E.col(0).cross(n);
  const double by = 1.0 / std::max(1e-6, 1.0 + E.col(0).dot(n));
  Matrix3d E_n;
  for (int k = 0; k < 3; ++k) {
    const Vector3d across = axis.cross(E.col(k));
    E_n.col(k) = E.col(k) + across + by * axis.cross(across);
  }
  return E_n;
}

/// It rubs across its normal n, as the frame has it; then the normal leans, towards where more of the cell is pressed,
/// and the gap is in units of the new one.
ContactAxes lean(const FrameContact& contact, const Matrix3d& R_FO, double last_N, ContactKinematics& kinematics,
                 Index i) {
  const Vector3d &n_F = kinematics.points[i].gap.n_F, lean_F = R_FO * contact.lean_O;
  // f = lambda |v|, v = n + lambda lean: where the lean is all, |v| is a root, which geometric means find at once.
  double length = 1.0;
  for (int k = 0; k < 5; ++k) length = std::sqrt(length * (n_F + last_N / length * lean_F).norm());
  // Where hardly anything of a cell is pressed it is far longer than n. Moved that way under its frame, the pulp would
  // give way by as much more than it was moved.
  constexpr double kLongest = 20.0;
  const double lambda_N = last_N / length * std::min(1.0, kLongest / length);
  const Vector3d v_F = n_F + lambda_N * lean_F;
  length = std::max(1e-6, v_F.norm());
  kinematics.gap_unit[i] = 1.0 / length;
  kinematics.gap_m[i] = (kinematics.points[i].gap.gap_m + lambda_N * contact.lean_m_per_N) / length;
  const Matrix3d across_n = turned(contact.E_F, n_F);
  ContactAxes axes{across_n, contact.E_F, across_n};
  axes.of_gap.col(0) = v_F / length;
  axes.of_pulp.col(0) *= contact.press / length;
  axes.of_object.col(0) /= length;
  return axes;
}

}  // namespace

ContactGap gap_at(const Model& model, const FrameContact& contact, const Isometry3d& X_FO, const State& state) {
  return contact_gap(contact, X_FO, displacement(state, contact), object_displacement(model, state, contact));
}

void place_bodies(const Model& model, const HandPose& pose, const State& state, ContactKinematics& kinematics) {
  kinematics.X_WO = state.X_WO;
  for (int k = 0; k < model.fingers(); ++k) {
    kinematics.X_FO[k] = pose.distal(model.scene.hand, k).inverse() * state.X_WO;
  }
}

void find_gaps(const Model& model, const Frame& frame, const State& state, ContactKinematics& kinematics) {
  object_displacements(model, frame, state, kinematics.u_O);
  // Each of these waits for roots and quotients of its own, but for no other one's.
  for (Index i = 0; i < frame.size(); ++i) {
    const FrameContact& contact = frame.contacts[i];
    ContactPoint& point = kinematics.points[i];
    point.u_F = displacement(state, contact);
    point.u_O = model.soft_object() ? Vector3d(kinematics.u_O.row(i)) : Vector3d::Zero();
    point.gap = contact_gap(contact, kinematics.X_FO[contact.finger], point.u_F, point.u_O);
  }
}

void contact_kinematics(const Model& model, const Frame& frame, const HandPose& pose, const State& state,
                        ContactKinematics& kinematics) {
  place_bodies(model, pose, state, kinematics);
  find_gaps(model, frame, state, kinematics);
  find_jacobians(model, frame, pose, state, kinematics);
}

void find_jacobians(const Model& model, const Frame& frame, const HandPose& pose, const State& state,
                    ContactKinematics& kinematics) {
  for (int k = 0; k < model.fingers(); ++k) {
    const Fingertip& tip = model.scene.hand.fingertips[k];
    const Isometry3d& X_WF = pose.distal(model.scene.hand, k);
    for (Index i = frame.begin[k]; i < frame.begin[k + 1]; ++i) {
      const FrameContact& contact = frame.contacts[i];
      const ContactPoint& point = kinematics.points[i];
      const bool fades = contact.fades();
      ContactAxes axes;
      if (fades) {
        axes = lean(contact, kinematics.X_FO[k].linear(), last_normal_N(state, contact), kinematics, i);
      } else {
        kinematics.gap_m[i] = point.gap.gap_m;
        kinematics.gap_unit[i] = 1.0;
        axes.of_gap = axes_of(point.gap.n_F, contact.E_F.col(1));
      }
      const Matrix3d& E_F = fades ? axes.of_pulp : axes.of_gap;
      const Matrix3d E_W = X_WF.linear() * axes.of_gap;
      const Vector3d c_W = X_WF * (contact.p_F - point.u_F) + kinematics.gap_m[i] * E_W.col(0);
      const Vector3d r = c_W - state.X_WO.translation();
      kinematics.E_F[i] = E_F;
      kinematics.E_W[i] = E_W;
      if (model.deformable()) kinematics.pulp_axes.middleRows<3>(3 * i) = E_F.transpose();
      if (model.soft_object()) {
        const Matrix3d E_O = state.X_WO.linear().transpose() * (X_WF.linear() * (fades ? axes.of_object : axes.of_gap));
        kinematics.E_O[i] = E_O;
        kinematics.object_tensors.middleRows<3>(3 * i) = E_O.transpose() * object_tensor(model, contact);
        kinematics.u_object_m.col(i) = E_O.transpose() * point.u_O;
      }
      kinematics.c_W[i] = c_W;
      Eigen::Matrix<double, 3, 4> J;
      if (tip.followers > 0 || model.scene.hand.slides) {
        J = finger_jacobian(model.scene.hand, pose, k, c_W).leftCols<4>();
      } else {
        for (int j = 0; j < 4; ++j) {
          J.col(j) = j < tip.joints ? joint_column(pose, tip.first_joint + j, c_W) : Vector3d(Vector3d::Zero());
        }
      }
      kinematics.J_finger.middleRows<3>(3 * i).noalias() = -E_W.transpose() * J;
      if (kinematics.J_fifth.size() > 0) {
        const Vector3d fifth =
            tip.joints > 4 ? Vector3d(finger_jacobian(model.scene.hand, pose, k, c_W).col(4)) : Vector3d::Zero();
        kinematics.J_fifth.segment<3>(3 * i) = -E_W.transpose() * fifth;
      }
      for (int axis = 0; axis < 3; ++axis) {
        auto row = kinematics.J_object.row(3 * i + axis);
        row.head<3>() = E_W.col(axis).transpose();
        row.segment<3>(3) = r.cross(E_W.col(axis)).transpose();
      }
    }
  }
}

}  // namespace thenar
