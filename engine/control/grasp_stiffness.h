#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "engine/control/control.h"
#include "engine/grasp/frame.h"
#include "engine/grasp/model.h"
#include "engine/grasp/muscles.h"
#include "engine/grasp/state.h"

namespace thenar {

using ObjectJoints = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, kMaxFingerJoints>;

/// How the forces on object and joints answer to small motions of both, contacts as they are: the second derivative of
/// the grasp's energy. With X the object's motion (of its origin, then its rotation; world axes) and q the joints',
///     X' A X - 2 sum_k X' B_k q_k + sum_k q_k' (D_k + M_k) q_k,
/// M_k the stiffness of finger k's muscles. Joints that nobody moves find their place, so that the object has
///     K_o = A - sum_k B_k (D_k + M_k)^-1 B_k',
/// a stiffness that is concave in M. With the motion of the object against the finger, rho = T X - J6 q,
///     rho' K rho        the pulp: K = R' C^-1 R, R the motion of its loaded contacts in their rows; where one slides,
///                       its normal row alone
///     2 f.(J_w q x rho) for forces turn with the finger in whose pulp they are
///     sum (f.r) I - sym(r f')  about the object's axes, and d(J'f)/dq of the joints: points move, forces stay
/// and the weights', which stay, too. A spring of the task adds to A.
struct GraspStiffness {
  Matrix6d A = Matrix6d::Zero();
  PerFinger<ObjectJoints> B;
  PerFinger<FingerMatrix> D;
  PerFinger<Matrix6d> pulps;  ///< T' K T: what of A is the pulps' stiffness, by finger.
  int contacts = 0;           ///< Loaded ones,
  int sliding = 0;            ///< and those of them that slide: stiff along their normals alone.

  [[nodiscard]] Matrix6d of_object(const PerFinger<FingerMatrix>& muscles) const;
};

/// What it is computed in. Memory for the model's most contacts, taken once.
struct StiffnessWorkspace {
  explicit StiffnessWorkspace(const Model& model);

  Eigen::MatrixXd C;  ///< Of a finger's loaded rows.
  Eigen::MatrixXd R;  ///< Their rigid motion; rows x 6.
};

/// Of the grasp at the snapshot of a frame, whose contacts bear `forces` [N] with this friction. Rigid fingertips give
/// way by 1e-8 m/N. A soft object is taken for a rigid one: there is none of these (see refuse_soft). Does not allocate.
[[nodiscard]] GraspStiffness grasp_stiffness(const Model& model, const Frame& frame, const HandPose& pose,
                                             std::span<const ContactForce> forces, double friction,
                                             const Eigen::Vector3d& gravity, StiffnessWorkspace& work);

/// A stiffness about the object's origin as one about another point, or back: K of twists there is P' K P.
[[nodiscard]] Matrix6d about(const Matrix6d& K, const Eigen::Vector3d& from_origin_m);

/// What a scene asks for, about the object's origin, world axes.
[[nodiscard]] Matrix6d wanted_stiffness(const ObjectStiffness& wanted, const Eigen::Isometry3d& X_WO);

}  // namespace thenar
