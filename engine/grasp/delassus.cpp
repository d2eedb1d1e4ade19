// SPDX-License-Identifier: Apache-2.0
#include "engine/grasp/delassus.h"

#include <algorithm>
#include <cmath>

#include "engine/grasp/object_compliance.h"

namespace thenar {

using Eigen::Index;
using Eigen::Matrix4d;
using Eigen::Vector3d;
using Eigen::Vector4d;

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

/// Likewise times L of joints with stiffness.
void mix_columns(const Hand& hand, const Frame& frame, const PerFinger<JointMatrix>& factor,
                 ContactKinematics& kinematics) {
  constexpr int kOwn = GroupedDelassus::kOwn;
  for (int k = 0; k < hand.fingers(); ++k) {
    const int joints = hand.fingertips[k].joints, some = std::min(joints, kOwn);
    const Index first = 3 * frame.begin[k], rows = 3 * frame.begin[k + 1] - first;
    // By rows: a row of J_mobile is then a sum of rows of four numbers.
    Eigen::Matrix<double, kOwn, kOwn, Eigen::RowMajor> L;
    if (some < kOwn) L.setZero();
    L.topLeftCorner(some, some) = factor[k].topLeftCorner(some, some);
    auto mobile = kinematics.J_mobile.middleRows(first, rows);
    mobile.noalias() = kinematics.J_finger.middleRows(first, rows) * L;
    if (kinematics.J_fifth.size() == 0) continue;
    auto fifth = kinematics.J_fifth_mobile.segment(first, rows);
    fifth.setZero();
    if (joints <= kOwn) continue;
    const auto J_fifth = kinematics.J_fifth.segment(first, rows);
    for (int c = 0; c < kOwn; ++c) mobile.col(c) += factor[k](kOwn, c) * J_fifth;
    for (int c = 0; c < kOwn; ++c) fifth += factor[k](c, kOwn) * kinematics.J_finger.col(c).segment(first, rows);
    fifth += factor[k](kOwn, kOwn) * J_fifth;
  }
}

/// Clears the columns of B and of I together: with B U lower triangular, U' B U = D, and h B^-1 = U (h D^-1) U'. A
/// joint that is not free is decoupled, and has no part. Four joints are usual, and sums of four numbers are quick.
template <class Square>
Square factor_of(const Square& damping, double mobility_per_joint, double step_s,
                 const std::array<bool, kMaxFingerJoints>& free) {
  using Column = Eigen::Matrix<double, Square::RowsAtCompileTime, 1, 0, Square::MaxRowsAtCompileTime, 1>;
  const auto n = damping.rows();
  Square B = damping, L = Square::Identity(n, n);
  for (Index j = 0; j < n; ++j) {
    if (free[j]) continue;
    B.row(j).setZero();
    B.col(j).setZero();
    B(j, j) = 1.0;
  }
#pragma GCC unroll 4
  for (Index j = 0; j < n; ++j) {
    const double share = 1.0 / B(j, j);
#pragma GCC unroll 4
    for (Index i = j + 1; i < n; ++i) {
      const double times = B(j, i) * share;
      B.col(i) -= times * B.col(j);
      L.col(i) -= times * L.col(j);
    }
  }
  const Column root = (step_s / mobility_per_joint / B.diagonal().array()).sqrt();
  for (Index j = 0; j < n; ++j) L.col(j) *= free[j] ? root[j] : 0.0;
  return L;
}

/// Springs of slides are taken at the end of the step, and what goes along a path does not give way.
[[gnu::noinline]] void set_slides(const Scene& scene, Mobility& all) {
  all.root.setZero(std::ssize(scene.hand.joints));
  for (int k = 0; k < std::ssize(scene.slides); ++k) {
    if (scene.has_path(k)) continue;
    const double b = scene.viscosity(k), own = scene.step_s / (b + scene.step_s * scene.slides[k].stiffness_N_per_m);
    all.root[scene.hand.fingertips[k].first_joint] = std::sqrt(own / all.joint);
  }
}

/// Of a finger's K.
template <class Square>
void add_stiffness(const Scene& scene, int k, const Square& stiffness, Mobility& mobility) {
  std::array<bool, kMaxFingerJoints> free;
  free.fill(true);
  Square damping = scene.step_s * stiffness;
  for (Index j = 0; j < damping.rows(); ++j) {
    damping(j, j) += scene.viscosity(k) * scene.hand.joints[scene.hand.fingertips[k].first_joint + j].drag;
  }
  mobility.damping[k] = damping;
  mobility.factor[k] = factor_of<Square>(damping, mobility.joint, scene.step_s, free);
}

}  // namespace

JointMatrix mobility_factor(const JointMatrix& damping, double mobility_per_joint, double step_s,
                            const std::array<bool, kMaxFingerJoints>& free) {
  if (damping.rows() == 4) {
    return factor_of<Matrix4d>(Matrix4d::Map(damping.data()), mobility_per_joint, step_s, free);
  }
  return factor_of<JointMatrix>(damping, mobility_per_joint, step_s, free);
}

void add_stiffness(const Scene& scene, const PerFinger<JointMatrix>& stiffness, Mobility& mobility) {
  mobility.damping = mobility.factor = stiffness;  // As many, of the same sizes.
  for (int k = 0; k < scene.hand.fingers(); ++k) {
    if (stiffness[k].rows() == 4) {
      add_stiffness<Matrix4d>(scene, k, Matrix4d::Map(stiffness[k].data()), mobility);
    } else {
      add_stiffness<JointMatrix>(scene, k, stiffness[k], mobility);
    }
  }
}

JointVector joint_motion(const Hand& hand, const Mobility& mobility, const JointVector& torque_Nm) {
  JointVector dq = mobility.joint * torque_Nm;
  if (mobility.is_stiff()) {
    for (int k = 0; k < hand.fingers(); ++k) {
      const Fingertip& tip = hand.fingertips[k];
      const JointMatrix& L = mobility.factor[k];
      if (tip.joints == 4) {
        const auto L_4 = Matrix4d::Map(L.data());
        auto own = dq.segment<4>(tip.first_joint);
        own = L_4 * Vector4d(L_4.transpose() * own);
        continue;
      }
      auto own = dq.segment(tip.first_joint, tip.joints);
      own = L.lazyProduct(L.transpose().lazyProduct(own).eval()).eval();
    }
  } else if (mobility.root.size() > 0) {
    dq.array() *= mobility.root.array().square();
  }
  return dq;
}

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
  if (!scene.slides.empty()) set_slides(scene, all);
  return all;
}

void set_shares(const Model& model, const Frame& frame, const Mobility& mobility, ContactKinematics& kinematics) {
  if (mobility.is_stiff()) {
    mix_columns(model.scene.hand, frame, mobility.factor, kinematics);
  } else if (mobility.root.size() > 0) {
    scale_columns(model.scene.hand, frame, mobility.root, kinematics);
  }
  for (std::size_t k = 0; k < kinematics.pulp_share.size(); ++k) {
    const auto gained = [&](const Pulp& pulp) { return 1.0 - retained_share(pulp.material, model.scene.step_s); };
    kinematics.pulp_share[k] = gained(model.pulps[k]) / gained(model.pulps.front());
  }
}

GroupedDelassus delassus_operator(const Model& model, const Frame& frame, const ContactKinematics& kinematics,
                                  const Mobility& mobility) {
  const bool alike = mobility.root.size() == 0 && !mobility.is_stiff();
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
    // Axes of contacts that fade change from tick to tick. What sweeps learn of them does not last: the slowest ticks
    // of a peg in its hole would take more sweeps, and the mean as many.
    const bool lasts = std::ranges::none_of(frame.contacts, &FrameContact::fades);
    W.list = lasts ? frame.list : -1;
    W.edition = lasts ? frame.compliance_edition : -1;
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
    if (mobility.is_stiff()) {
      const JointMatrix& L = mobility.factor[k];
      const auto own = solve.own_motion.col(k).head(tip.joints);
      if (tip.joints == 4) {
        dq.segment<4>(tip.first_joint) += Matrix4d::Map(L.data()) * own.head<4>();
      } else {
        dq.segment(tip.first_joint, tip.joints) += L.lazyProduct(own);
      }
      continue;
    }
    for (int c = 0; c < tip.joints; ++c) {
      const int j = tip.first_joint + c;
      dq[j] += mobility.root.size() == 0 ? solve.own_motion(c, k) : mobility.root[j] * solve.own_motion(c, k);
    }
  }
}

}  // namespace thenar
