// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "engine/control/control.h"
#include "engine/grasp/contact_kinematics.h"
#include "engine/grasp/frame.h"
#include "engine/grasp/model.h"
#include "engine/grasp/state.h"
#include "engine/hand/muscles.h"

namespace thenar {

using ObjectJoints = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, kMaxFingerJoints>;

/// The stiffness of object and joints against small motions of both, with unchanged contacts. With X the object's
/// motion (of its origin, then its rotation; world axes) and q the joints' of a finger, the restoring forces are
///     A X - sum_k B_k q_k  and  (D_k + M_k) q_k - B_joints,k' X,
/// M_k the stiffness of finger k's muscles. With joints in equilibrium the object has
///     K_o = A - sum_k B_k (D_k + M_k)^-1 B_joints,k',
/// a stiffness that increases with M, and is concave in it. Its terms are, with rho = T X - J6 q the motion of the
/// object relative to the finger and J_w q the finger's rotation,
///     rho' K rho        the pulp: K = R' C^-1 R, R the motion of its loaded contacts in their rows; where one slides,
///                       its normal row alone
///     2 f.(J_w q x rho) as forces rotate with the finger of their pulp
///     sum (f.r) I - sym(r f') about the object's axes, and d(J'f)/dq of the joints: points move, forces are constant
/// and those of the weights, also constant. A spring of the task adds to A. One term is not the derivative of an
/// energy, and makes B_joints differ from B, and A and D unsymmetric, by some percent: the difference of a pulp's C
/// across and along normals, as its axes rotate with the object's surface.
struct GraspStiffness {
  Matrix6d A = Matrix6d::Zero();
  PerFinger<ObjectJoints> B, B_joints;
  PerFinger<JointMatrix> D;
  PerFinger<Matrix6d> pulps;  ///< T' K T: part of A from the pulps' stiffness, by finger.
  int contacts = 0;           ///< Number of loaded contacts.
  int sliding = 0;            ///< Number of these that slide: stiff along their normals alone.

  [[nodiscard]] Matrix6d of_object(const PerFinger<JointMatrix>& muscles) const;
};

/// What a finger's contacts at their cones' edge add to the stiffness of a grasp whose contacts all stick. Such a
/// contact slips by lambda >= 0 against its friction, or keeps its force within the cone:
///     0 <= w = V_X X - V_q q + G lambda  _|_  lambda >= 0,
/// w = mu f_n - |f_t|. The slips add Q_X lambda to the restoring forces on the object, and -Q_q lambda to the joints'.
struct FingerSlips {
  Eigen::MatrixXd Q_X, Q_q;  ///< 6 x slips, joints x slips.
  Eigen::MatrixXd V_X, V_q;  ///< slips x 6, slips x joints.
  Eigen::MatrixXd G;         ///< slips x slips.
};

/// Memory of grasp_stiffness() for the model's most contacts, allocated once.
struct StiffnessWorkspace {
  explicit StiffnessWorkspace(const Model& model);

  Eigen::MatrixXd C;  ///< Compliance of a finger's loaded rows.
  Eigen::MatrixXd R;  ///< Their rigid motion, and the change of C f by their tilt; rows x 9.
};

/// The position of a contact, and its axes n, t1, t2 as columns; world.
struct ContactPlace {
  Eigen::Vector3d c_W;
  Eigen::Matrix3d E_W;
};

/// Returns the contacts' places in a tick.
[[nodiscard]] std::vector<ContactPlace> places_of(const ContactKinematics& now, Eigen::Index contacts);

/// Returns the contacts' places in a frame, on the rest shapes: wrong by the pulps' shear, which gives an error of K_o
/// of 2 % at a grip force of 2 N, 7 % at 5 N. Does not allocate beyond the capacity of `places`.
void places_of(const Frame& frame, const HandPose& pose, const Hand& hand, std::vector<ContactPlace>& places);

/// The loads of a frame's contacts.
struct ContactLoads {
  std::span<const ContactForce> forces;  ///< Forces, sorted as in a state [N].
  std::span<const ContactPlace> places;  ///< Places of the frame's contacts.
  double friction = 0.0;
};

/// Computes the stiffness of the grasp at the snapshot of a frame. Rigid fingertips have a compliance of 1e-8 m/N; an
/// object's softness is neglected. Does not allocate.
[[nodiscard]] GraspStiffness grasp_stiffness(const Model& model, const Frame& frame, const HandPose& pose,
                                             const ContactLoads& loads, const Eigen::Vector3d& gravity,
                                             StiffnessWorkspace& work);

/// Likewise as if all contacts stuck, and finds what those add that use this share of their friction. Allocates.
[[nodiscard]] GraspStiffness sticking_stiffness(const Model& model, const Frame& frame, const HandPose& pose,
                                                const ContactLoads& loads, const Eigen::Vector3d& gravity, double share,
                                                PerFinger<FingerSlips>& slips);

/// Returns the object's rotational stiffness under a constant force at its point r from the origin: (f.r) I - sym(r
/// f').
[[nodiscard]] Eigen::Matrix3d turning_stiffness(const Eigen::Vector3d& f, const Eigen::Vector3d& r);

/// Transforms a stiffness about the object's origin to another point, or back: K of twists there is P' K P.
[[nodiscard]] Matrix6d about(const Matrix6d& K, const Eigen::Vector3d& from_origin_m);

/// Returns the stiffness that a scene demands, about the object's origin, world axes.
[[nodiscard]] Matrix6d wanted_stiffness(const ObjectStiffness& wanted, const Eigen::Isometry3d& X_WO);

}  // namespace thenar
