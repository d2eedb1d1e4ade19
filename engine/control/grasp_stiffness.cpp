// SPDX-License-Identifier: Apache-2.0
#include "engine/control/grasp_stiffness.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace thenar {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

namespace {

constexpr double kRigid_m_per_N = 1e-8;
// A contact this near to its cone slides: the solver's tolerance.
constexpr double kAtLimit = 1e-5;

using JointsObject = Eigen::Matrix<double, Eigen::Dynamic, 6, 0, kMaxFingerJoints, 6>;

Matrix3d cross_matrix(const Vector3d& v) {
  Matrix3d X;
  X << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return X;
}

/// A loaded contact of a finger.
struct Loaded {
  Index contact;  ///< In the frame.
  bool slides;
  Vector3d point_m, force_N;  ///< World.
  Matrix3d E_W;
};

/// The sum of one finger's loads.
struct Patch {
  Vector3d centre_m = Vector3d::Zero(), force_N = Vector3d::Zero();
  Matrix3d moments_Nm = Matrix3d::Zero();  ///< S: sum of f d', d from the centre.
};

/// Calls visit(loaded) for the contacts of a finger that bear load.
template <typename Visit>
void for_each_loaded(const Frame& frame, int k, const ContactLoads& loads, const Visit& visit) {
  auto force = loads.forces.begin();
  for (Index i = frame.begin[k]; i < frame.begin[k + 1]; ++i) {
    const FrameContact& contact = frame.contacts[i];
    while (force != loads.forces.end() && id_of(*force) < id_of(contact)) ++force;
    if (force == loads.forces.end()) return;
    if (id_of(*force) != id_of(contact) || !(force->f_C[0] > 0.0)) continue;
    const bool slides = force->f_C.tail<2>().norm() >= (1.0 - kAtLimit) * loads.friction * force->f_C[0];
    visit(Loaded{i, slides, loads.places[i].c_W, loads.places[i].E_W * force->f_C, loads.places[i].E_W});
  }
}

/// The stiffness of a pulp's forces on the object against motions at its patch's centre.
struct PulpAnswer {
  Matrix6d K;                        ///< To the object's motion against the finger.
  Eigen::Matrix<double, 6, 3> tilt;  ///< To its turn against it, which the normals of the contacts follow.
};

/// Returns the change of C f at a contact, by forces at another one, as both normals rotate about the world's axes.
Matrix3d turned_compliance(const SurfaceCompliance& C, Index i, Index j, const Loaded& at, const Loaded& by,
                           const Matrix3d& R_WF) {
  const Vector3d r = R_WF * (C.p_m.row(i) - C.p_m.row(j)).transpose();
  const Matrix3d bent = C.a(i, j) * Matrix3d::Identity() + C.b(i, j) * r * r.transpose();
  const Vector3d n_i = at.E_W.col(0), n_j = by.E_W.col(0);
  const auto across = [](const Vector3d& n, const Vector3d& v) -> Vector3d { return v - n * n.dot(v); };
  const Vector3d bent_f = bent * across(n_j, by.force_N);
  Matrix3d change;
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3d dn_i = Vector3d::Unit(axis).cross(n_i), dn_j = Vector3d::Unit(axis).cross(n_j);
    const Vector3d less_f = dn_j * n_j.dot(by.force_N) + n_j * dn_j.dot(by.force_N);
    change.col(axis) = dn_i * n_i.dot(bent_f) + n_i * dn_i.dot(bent_f) + across(n_i, bent * less_f);
  }
  return change;
}

/// Computes R <- L^-1 R with C = L L', of which the lower triangle counts. Eigen's products would be copies that other
/// translation units may have made slower.
void solve_lower_factor(Eigen::MatrixXd& C, Eigen::Ref<Eigen::MatrixXd> R) {
  for (Index j = 0; j < R.rows(); ++j) {
    C(j, j) = std::sqrt(C(j, j));
    const double over = 1.0 / C(j, j);
    for (Index i = j + 1; i < R.rows(); ++i) C(i, j) *= over;
    for (Index k = j + 1; k < R.rows(); ++k) {
      for (Index i = k; i < R.rows(); ++i) C(i, k) -= C(i, j) * C(k, j);
    }
    for (Index c = 0; c < R.cols(); ++c) {
      R(j, c) *= over;
      for (Index i = j + 1; i < R.rows(); ++i) R(i, c) -= C(i, j) * R(j, c);
    }
  }
}

/// Computes A^-1 X by elimination without pivots, for A that is nearly symmetric.
JointsObject solved(JointMatrix A, JointsObject X) {
  const Index n = A.rows();
  for (Index j = 0; j < n; ++j) {
    for (Index i = 0; i < n; ++i) {
      if (i == j) continue;
      const double part = A(i, j) / A(j, j);
      for (Index c = j; c < n; ++c) A(i, c) -= part * A(j, c);
      for (Index c = 0; c < 6; ++c) X(i, c) -= part * X(j, c);
    }
  }
  for (Index j = 0; j < n; ++j) {
    for (Index c = 0; c < 6; ++c) X(j, c) /= A(j, j);
  }
  return X;
}

/// The slips of a finger's contacts, at its patch's centre.
struct PulpSlips {
  double friction = 0.0;                            ///< Contacts that use so much of theirs slip.
  Eigen::Matrix<double, 6, Eigen::Dynamic> P;       ///< Of lambda, to the object's restoring forces.
  Eigen::Matrix<double, Eigen::Dynamic, 6> S;       ///< Of the object's motion against the finger, to w,
  Eigen::Matrix<double, Eigen::Dynamic, 3> S_turn;  ///< and of its turn against it.
  MatrixXd G;
};

/// Sets two columns for each slip: its direction, and that of the force that w is of; returns their number.
Index set_slips(const Frame& frame, int k, const ContactLoads& loads, PulpSlips& slips, MatrixXd& columns) {
  Index row = 0, count = 0;
  slips.S_turn.resize(frame.begin[k + 1] - frame.begin[k], 3);
  for_each_loaded(frame, k, loads, [&](const Loaded& one) {
    const Vector3d f_C = one.E_W.transpose() * one.force_N;
    const double tangential_N = f_C.tail<2>().norm();
    if (tangential_N > 0.0 && tangential_N >= (1.0 - kAtLimit) * slips.friction * f_C[0]) {
      Vector3d along(0.0, f_C[1] / tangential_N, f_C[2] / tangential_N);
      columns.middleCols<2>(9 + 2 * count).setZero();
      columns.block<3, 1>(row, 9 + 2 * count) = along;
      along[0] = -tangential_N / f_C[0];
      columns.block<3, 1>(row, 10 + 2 * count) = along;
      slips.S_turn.row(count++) = one.force_N.cross(one.E_W * along).transpose();
    }
    row += 3;
  });
  slips.S_turn.conservativeResize(count, 3);
  return count;
}

/// `slips`: null, or those of contacts none of which slides by their loads.
PulpAnswer pulp_answer(const Model& model, const Frame& frame, const HandPose& pose, int k, const ContactLoads& loads,
                       const Patch& patch, StiffnessWorkspace& work, PulpSlips* slips) {
  Index rows = 0;
  const Matrix3d R_WF = pose.distal(model.scene.hand, k).linear();
  for_each_loaded(frame, k, loads, [&](const Loaded& one) {
    Index columns = 0;
    Matrix3d tilt = Matrix3d::Zero();
    for_each_loaded(frame, k, loads, [&](const Loaded& other) {
      const Index i = one.contact - frame.begin[k], j = other.contact - frame.begin[k];
      if (model.deformable()) tilt += turned_compliance(frame.compliance[k], i, j, one, other, R_WF);
      if (other.contact > one.contact) return;
      const Matrix3d C_ij =
          model.deformable() ? frame.compliance[k].entry(i, j, R_WF.transpose() * one.E_W, R_WF.transpose() * other.E_W)
                             : (i == j ? kRigid_m_per_N : 0.0) * Matrix3d::Identity();
      for (int b = 0; b < (other.slides ? 1 : 3); ++b) {
        for (int a = 0; a < (one.slides ? 1 : 3); ++a) {
          work.C(rows + a, columns + b) = work.C(columns + b, rows + a) = C_ij(a, b);
        }
      }
      columns += other.slides ? 1 : 3;
    });
    const Vector3d d = one.point_m - patch.centre_m;
    for (int a = 0; a < (one.slides ? 1 : 3); ++a, ++rows) {
      work.R.row(rows).head<9>() << one.E_W.col(a).transpose(), d.cross(one.E_W.col(a)).transpose(),
          one.E_W.col(a).transpose() * tilt;
    }
  });
  const Index count = slips != nullptr ? set_slips(frame, k, loads, *slips, work.R) : 0;
  auto R = work.R.topLeftCorner(rows, 9 + 2 * count);
  solve_lower_factor(work.C, R);
  const auto motion = R.leftCols<6>();
  if (slips != nullptr) {
    MatrixXd goes(rows, count), holds(rows, count);
    for (Index i = 0; i < count; ++i) {
      goes.col(i) = R.col(9 + 2 * i);
      holds.col(i) = R.col(10 + 2 * i);
    }
    slips->P = motion.transpose().lazyProduct(goes);
    slips->S = holds.transpose().lazyProduct(motion);
    slips->S_turn -= holds.transpose().lazyProduct(R.middleCols<3>(6));
    slips->G = holds.transpose().lazyProduct(goes);
  }
  return {motion.transpose().lazyProduct(motion), motion.transpose().lazyProduct(R.middleCols<3>(6))};
}

/// What a grasp's slips are found with.
struct SlipSearch {
  double friction;
  PerFinger<FingerSlips>& fingers;
};

void add_finger(const Model& model, const Frame& frame, const HandPose& pose, int k, const ContactLoads& loads,
                StiffnessWorkspace& work, SlipSearch* search, GraspStiffness& all) {
  const Hand& hand = model.scene.hand;
  const Fingertip& tip = hand.fingertips[k];
  const Vector3d origin_m = frame.X_WO.translation();
  Patch patch;
  double load_N = 0.0;
  for_each_loaded(frame, k, loads, [&](const Loaded& one) {
    patch.force_N += one.force_N;
    const double normal_N = one.force_N.dot(one.E_W.col(0));
    patch.centre_m += normal_N * one.point_m;
    load_N += normal_N;
    ++all.contacts;
    all.sliding += one.slides ? 1 : 0;
    all.A.bottomRightCorner<3, 3>() += turning_stiffness(one.force_N, one.point_m - origin_m);
    all.D[k] += force_stiffness(hand, pose, hand.segments[tip.segment], one.point_m, one.force_N);
  });
  if (!(load_N > 0.0)) return;
  patch.centre_m /= load_N;
  for_each_loaded(frame, k, loads, [&](const Loaded& one) {
    patch.moments_Nm += one.force_N * (one.point_m - patch.centre_m).transpose();
  });
  PulpSlips slips;
  if (search != nullptr) slips.friction = search->friction;
  const auto [K, tilt] = pulp_answer(model, frame, pose, k, loads, patch, work, search != nullptr ? &slips : nullptr);
  Matrix6d T = Matrix6d::Identity();
  T.topRightCorner<3, 3>() = -cross_matrix(patch.centre_m - origin_m);
  ObjectJoints J(6, tip.joints);
  const FingerJacobian turns = turning_axes(hand, pose, k);
  J.topRows<3>() = finger_jacobian(hand, pose, k, patch.centre_m).leftCols(tip.joints);
  J.bottomRows<3>() = turns.leftCols(tip.joints);
  Eigen::Matrix<double, 6, 3> Y;
  Y << cross_matrix(patch.force_N), patch.moments_Nm - patch.moments_Nm.trace() * Matrix3d::Identity();
  const auto turns_k = turns.leftCols(tip.joints);
  const ObjectJoints K_J = K.lazyProduct(J), turned = Y.lazyProduct(turns_k), tilted = tilt.lazyProduct(turns_k);
  all.pulps[k] = T.transpose() * K * T;
  all.A += all.pulps[k];
  all.A.rightCols<3>() -= T.transpose() * tilt;
  all.B[k] = T.transpose().lazyProduct(K_J - turned - tilted);
  all.B_joints[k] = T.transpose().lazyProduct(K_J - turned);
  all.B_joints[k].bottomRows<3>() -= tilt.transpose().lazyProduct(J);
  const JointMatrix mixed = J.transpose().lazyProduct(turned);
  all.D[k] += J.transpose().lazyProduct(K_J - tilted).eval() - mixed - mixed.transpose();
  if (search == nullptr) return;
  MatrixXd V_X = slips.S.lazyProduct(T);
  V_X.rightCols<3>() += slips.S_turn;
  search->fingers[k] = {T.transpose().lazyProduct(slips.P), J.transpose().lazyProduct(slips.P), V_X,
                        slips.S.lazyProduct(J) + slips.S_turn.lazyProduct(turns_k), slips.G};
}

}  // namespace

Matrix3d turning_stiffness(const Vector3d& f, const Vector3d& r) {
  return f.dot(r) * Matrix3d::Identity() - 0.5 * (f * r.transpose() + r * f.transpose());
}

std::vector<ContactPlace> places_of(const ContactKinematics& now, Index contacts) {
  std::vector<ContactPlace> places(contacts);
  for (Index i = 0; i < contacts; ++i) places[i] = {now.c_W[i], now.E_W[i]};
  return places;
}

void places_of(const Frame& frame, const HandPose& pose, const Hand& hand, std::vector<ContactPlace>& places) {
  places.resize(frame.contacts.size());
  for (std::size_t i = 0; i < places.size(); ++i) {
    const FrameContact& contact = frame.contacts[i];
    places[i] = {frame.X_WO * contact.s_O, pose.distal(hand, contact.finger).linear() * contact.E_F};
  }
}

StiffnessWorkspace::StiffnessWorkspace(const Model& model)
    : C(3 * model.max_contacts, 3 * model.max_contacts), R(3 * model.max_contacts, 9) {}

Matrix6d GraspStiffness::of_object(const PerFinger<JointMatrix>& muscles) const {
  Matrix6d K = A;
  for (std::size_t k = 0; k < B.size(); ++k) {
    const JointMatrix joints = D[k] + muscles[k];
    K -= B[k].lazyProduct(solved(joints, B_joints[k].transpose()));
  }
  return K;
}

namespace {

GraspStiffness stiffness_of(const Model& model, const Frame& frame, const HandPose& pose, const ContactLoads& loads,
                            const Vector3d& gravity, StiffnessWorkspace& work, SlipSearch* search) {
  const Scene& scene = model.scene;
  GraspStiffness all;
  all.B = all.B_joints = PerFinger<ObjectJoints>(model.fingers());
  all.D = PerFinger<JointMatrix>(model.fingers());
  all.pulps = PerFinger<Matrix6d>(model.fingers(), Matrix6d::Zero());
  for (int k = 0; k < model.fingers(); ++k) {
    all.B[k] = all.B_joints[k] = ObjectJoints::Zero(6, scene.hand.fingertips[k].joints);
    all.D[k] = gravity_stiffness(scene.hand, pose, k, gravity);
    add_finger(model, frame, pose, k, loads, work, search, all);
  }
  all.A.bottomRightCorner<3, 3>() +=
      turning_stiffness(scene.object.mass_kg * gravity, frame.X_WO.linear() * scene.object.centre_of_mass_m);
  if (const auto& spring = scene.task.spring) {
    all.A.diagonal().head<3>().array() += spring->translation_N_per_m;
    all.A.diagonal().tail<3>().array() += spring->rotation_Nm_per_rad;
  }
  return all;
}

}  // namespace

GraspStiffness grasp_stiffness(const Model& model, const Frame& frame, const HandPose& pose, const ContactLoads& loads,
                               const Vector3d& gravity, StiffnessWorkspace& work) {
  return stiffness_of(model, frame, pose, loads, gravity, work, nullptr);
}

GraspStiffness sticking_stiffness(const Model& model, const Frame& frame, const HandPose& pose,
                                  const ContactLoads& loads, const Vector3d& gravity, double share,
                                  PerFinger<FingerSlips>& slips) {
  StiffnessWorkspace work(model);
  work.R.resize(work.R.rows(), 9 + 2 * model.max_contacts);
  slips = PerFinger<FingerSlips>(model.fingers());
  SlipSearch search{share * loads.friction, slips};
  constexpr double kSticks = std::numeric_limits<double>::infinity();
  return stiffness_of(model, frame, pose, {loads.forces, loads.places, kSticks}, gravity, work, &search);
}

Matrix6d about(const Matrix6d& K, const Vector3d& from_origin_m) {
  // A twist at the point is the origin's with p = p_o + w x r: X_o = P X.
  Matrix6d P = Matrix6d::Identity();
  P.topRightCorner<3, 3>() = cross_matrix(from_origin_m);
  return P.transpose() * K * P;
}

Matrix6d wanted_stiffness(const ObjectStiffness& wanted, const Eigen::Isometry3d& X_WO) {
  Matrix6d K = Matrix6d::Zero();
  const Matrix3d& R = X_WO.linear();
  K.topLeftCorner<3, 3>() = R * wanted.translation_N_per_m.asDiagonal() * R.transpose();
  K.bottomRightCorner<3, 3>() = R * wanted.rotation_Nm_per_rad.asDiagonal() * R.transpose();
  return about(K, -(R * wanted.centre_m));
}

}  // namespace thenar
