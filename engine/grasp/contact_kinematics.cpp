// SPDX-License-Identifier: Apache-2.0
#include "engine/grasp/contact_kinematics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "engine/grasp/contact_gaps.h"
#include "engine/grasp/lanes.h"
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

void place_bodies(const Model& model, const HandPose& pose, const State& state, ContactKinematics& kinematics) {
  kinematics.X_WO = state.X_WO;
  for (int k = 0; k < model.fingers(); ++k) {
    kinematics.X_FO[k] = pose.distal(model.scene.hand, k).inverse() * state.X_WO;
  }
}

// Inlined as a whole, lanes stay in registers between steps.
[[gnu::flatten]] void find_gaps(const Model& model, const Frame& frame, const State& state,
                                ContactKinematics& kinematics) {
  object_displacements(model, frame, state, kinematics.u_O);
  for_each_block(frame.contacts, [&](Index first, std::span<const FrameContact> block) {
    lanes::Vector u_O = {};
    if (model.soft_object()) {
      for (int lane = 0; lane < std::ssize(block); ++lane) lanes::set(u_O, lane, kinematics.u_O.row(first + lane));
    }
    const ContactGaps gaps = contact_gaps(block, kinematics.X_FO[block.front().finger], state, u_O);
    for (int lane = 0; lane < std::ssize(block); ++lane) {
      kinematics.points[first + lane] = {
          lanes::get(gaps.u_F, lane), lanes::get(u_O, lane), {gaps.gap_m[lane], lanes::get(gaps.n_F, lane)}};
    }
  });
}

void contact_kinematics(const Model& model, const Frame& frame, const HandPose& pose, const State& state,
                        ContactKinematics& kinematics) {
  place_bodies(model, pose, state, kinematics);
  find_gaps(model, frame, state, kinematics);
  find_jacobians(model, frame, pose, state, kinematics);
}

namespace {

/// The axes of the gaps and slips of up to four contacts, distal frame, and their gaps along the first ones.
struct LaneAxes {
  lanes::Axes of_gap;
  lanes::Numbers gap_m;
};

/// Finds the axes of `count` contacts from `first` on, and sets what depends on them and the gaps alone.
LaneAxes find_axes(const Model& model, const Frame& frame, const Isometry3d& X_FO, const State& state, Index first,
                   int count, ContactKinematics& kinematics) {
  const auto gap = [&](int lane) -> const ContactGap& {
    return kinematics.points[first + std::min(lane, count - 1)].gap;
  };
  const auto tangent = [&](int lane) { return frame.contacts[first + std::min(lane, count - 1)].E_F.col(1); };
  LaneAxes axes{
      lanes::axes_of(lanes::gather([&](int lane) -> const Vector3d& { return gap(lane).n_F; }), lanes::gather(tangent)),
      lanes::gather_numbers([&](int lane) { return gap(lane).gap_m; })};
  for (int lane = 0; lane < count; ++lane) {
    kinematics.gap_m[first + lane] = axes.gap_m[lane];
    kinematics.gap_unit[first + lane] = 1.0;
  }
  lanes::write(axes.of_gap, count, kinematics.E_F[first].data());
  if (model.deformable()) lanes::write(axes.of_gap, count, kinematics.pulp_axes.row(3 * first).data());
  for (int lane = 0; lane < count; ++lane) {
    const Index i = first + lane;
    const FrameContact& contact = frame.contacts[i];
    const Matrix3d* of_object = &kinematics.E_F[i];
    ContactAxes leaning;
    if (contact.fades()) {
      leaning = lean(contact, X_FO.linear(), last_normal_N(state, contact), kinematics, i);
      axes.gap_m[lane] = kinematics.gap_m[i];
      for (int k = 0; k < 3; ++k) lanes::set(axes.of_gap[k], lane, leaning.of_gap.col(k));
      kinematics.E_F[i] = leaning.of_pulp;
      if (model.deformable()) kinematics.pulp_axes.middleRows<3>(3 * i) = leaning.of_pulp.transpose();
      of_object = &leaning.of_object;
    }
    if (model.soft_object()) {
      Matrix3d& E_O = kinematics.E_O[i];
      E_O = X_FO.linear().transpose() * *of_object;
      kinematics.object_tensors.middleRows<3>(3 * i) = E_O.transpose() * object_tensor(model, contact);
      kinematics.u_object_m.col(i) = E_O.transpose() * kinematics.points[i].u_O;
    }
  }
  return axes;
}

/// J_k of points c of the first `count` lanes: its columns.
std::array<lanes::Vector, GroupedDelassus::kOwn> joint_columns(const Hand& hand, const HandPose& pose, int k, int count,
                                                               const lanes::Vector& c_W) {
  const Fingertip& tip = hand.fingertips[k];
  std::array<lanes::Vector, GroupedDelassus::kOwn> J;
  if (tip.followers > 0 || hand.slides) {
    J = {};
    for (int lane = 0; lane < count; ++lane) {
      const FingerJacobian of_lane = finger_jacobian(hand, pose, k, lanes::get(c_W, lane));
      for (int j = 0; j < GroupedDelassus::kOwn; ++j) lanes::set(J[j], lane, of_lane.col(j));
    }
    return J;
  }
  for (int j = 0; j < GroupedDelassus::kOwn; ++j) {
    const int joint = tip.first_joint + j;
    J[j] = j < tip.joints ? lanes::cross(pose.axis[joint], lanes::minus(c_W, pose.origin_m[joint])) : lanes::Vector{};
  }
  return J;
}

}  // namespace

// Inlined as a whole, as find_gaps().
[[gnu::flatten]] void find_jacobians(const Model& model, const Frame& frame, const HandPose& pose, const State& state,
                                     ContactKinematics& kinematics) {
  const Hand& hand = model.scene.hand;
  for_each_block(frame.contacts, [&](Index first, std::span<const FrameContact> block) {
    const int k = block.front().finger, count = static_cast<int>(std::ssize(block));
    const Isometry3d& X_WF = pose.distal(hand, k);
    const LaneAxes axes = find_axes(model, frame, kinematics.X_FO[k], state, first, count, kinematics);
    lanes::Vector c_W = lanes::product(X_WF.linear(), lanes::gather([&](int lane) -> Vector3d {
                                         const int of = std::min(lane, count - 1);
                                         return block[of].p_F - kinematics.points[first + of].u_F;
                                       }));
    lanes::Axes E_W;
    for (int axis = 0; axis < 3; ++axis) E_W[axis] = lanes::product(X_WF.linear(), axes.of_gap[axis]);
    for (int r = 0; r < 3; ++r) c_W[r] += X_WF.translation()[r] + axes.gap_m * E_W[0][r];
    lanes::write(E_W, count, kinematics.E_W[first].data());
    lanes::write(c_W, count, kinematics.c_W[first].data(), 3);

    const auto J = joint_columns(hand, pose, k, count, c_W);
    const lanes::Vector r = lanes::minus(c_W, state.X_WO.translation());
    for (int axis = 0; axis < 3; ++axis) {
      const lanes::Vector &e = E_W[axis], turn = lanes::cross(r, e);
      lanes::write(std::array{-lanes::dot(e, J[0]), -lanes::dot(e, J[1]), -lanes::dot(e, J[2]), -lanes::dot(e, J[3])},
                   count, kinematics.J_finger.row(3 * first + axis).data(), 3 * GroupedDelassus::kOwn);
      lanes::write(std::array{e[0], e[1], e[2], turn[0], turn[1], turn[2], lanes::Numbers{}, lanes::Numbers{}}, count,
                   kinematics.J_object.row(3 * first + axis).data(), 3 * GroupedDelassus::kPadded);
    }
    if (kinematics.J_fifth.size() == 0) return;
    for (Index i = first; i < first + count; ++i) {
      const Vector3d fifth = hand.fingertips[k].joints > 4
                                 ? Vector3d(finger_jacobian(hand, pose, k, kinematics.c_W[i]).col(4))
                                 : Vector3d::Zero();
      kinematics.J_fifth.segment<3>(3 * i) = -kinematics.E_W[i].transpose() * fifth;
    }
  });
}

}  // namespace thenar
