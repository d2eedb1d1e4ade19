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

/// How the forces on object and joints answer to small motions of both, contacts as they are. With X the object's
/// motion (of its origin, then its rotation; world axes) and q the joints' of a finger, the forces that drive them back
/// are
///     A X - sum_k B_k q_k  and  (D_k + M_k) q_k - B_joints,k' X,
/// M_k the stiffness of finger k's muscles. Joints that nobody moves find their place, so that the object has
///     K_o = A - sum_k B_k (D_k + M_k)^-1 B_joints,k',
/// a stiffness that grows with M, and is concave in it. It is made of, with rho = T X - J6 q the motion of the object
/// against the finger and J_w q the finger's turn,
///     rho' K rho        the pulp: K = R' C^-1 R, R the motion of its loaded contacts in their rows; where one slides,
///                       its normal row alone
///     2 f.(J_w q x rho) for forces turn with the finger in whose pulp they are
///     sum (f.r) I - sym(r f')  about the object's axes, and d(J'f)/dq of the joints: points move, forces stay
/// and the weights', which stay, too. A spring of the task adds to A. One part is not the derivative of an energy, and
/// makes B_joints differ from B, and A and D unsymmetric, by some percents: how C of a pulp across normals and along
/// them differs, for its axes turn with the object's surface.
struct GraspStiffness {
  Matrix6d A = Matrix6d::Zero();
  PerFinger<ObjectJoints> B, B_joints;
  PerFinger<JointMatrix> D;
  PerFinger<Matrix6d> pulps;  ///< T' K T: what of A is the pulps' stiffness, by finger.
  int contacts = 0;           ///< Loaded ones,
  int sliding = 0;            ///< and those of them that slide: stiff along their normals alone.

  [[nodiscard]] Matrix6d of_object(const PerFinger<JointMatrix>& muscles) const;
};

/// What it is computed in. Memory for the model's most contacts, taken once.
struct StiffnessWorkspace {
  explicit StiffnessWorkspace(const Model& model);

  Eigen::MatrixXd C;  ///< Of a finger's loaded rows.
  Eigen::MatrixXd R;  ///< Their rigid motion, and what their tilt changes of C f; rows x 9.
};

/// Where a contact is, and its axes n, t1, t2 as columns; world.
struct ContactPlace {
  Eigen::Vector3d c_W;
  Eigen::Matrix3d E_W;
};

/// As a tick has them.
[[nodiscard]] std::vector<ContactPlace> places_of(const ContactKinematics& now, Eigen::Index contacts);

/// As a frame alone has them, on the rest shapes: off by how far the pulps are sheared, which makes K_o wrong by 2 %
/// at a squeeze of 2 N, 7 % at 5 N. Does not allocate beyond the capacity of `places`.
void places_of(const Frame& frame, const HandPose& pose, const Hand& hand, std::vector<ContactPlace>& places);

/// What a frame's contacts bear.
struct ContactLoads {
  std::span<const ContactForce> forces;  ///< Sorted as in a state [N].
  std::span<const ContactPlace> places;  ///< Of the frame's contacts.
  double friction = 0.0;
};

/// Of the grasp at the snapshot of a frame. Rigid fingertips give way by 1e-8 m/N; that an object is soft is left out.
/// Does not allocate.
[[nodiscard]] GraspStiffness grasp_stiffness(const Model& model, const Frame& frame, const HandPose& pose,
                                             const ContactLoads& loads, const Eigen::Vector3d& gravity,
                                             StiffnessWorkspace& work);

/// Of the object's turns against a force that keeps its direction at one of its points, r from the origin:
/// (f.r) I - sym(r f').
[[nodiscard]] Eigen::Matrix3d turning_stiffness(const Eigen::Vector3d& f, const Eigen::Vector3d& r);

/// A stiffness about the object's origin as one about another point, or back: K of twists there is P' K P.
[[nodiscard]] Matrix6d about(const Matrix6d& K, const Eigen::Vector3d& from_origin_m);

/// What a scene asks for, about the object's origin, world axes.
[[nodiscard]] Matrix6d wanted_stiffness(const ObjectStiffness& wanted, const Eigen::Isometry3d& X_WO);

}  // namespace thenar
