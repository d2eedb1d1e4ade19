// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>

#include "engine/grasp/contact_kinematics.h"
#include "engine/grasp/frame.h"
#include "engine/grasp/model.h"
#include "engine/hand/muscles.h"
#include "solvers/grouped_delassus.h"

namespace thenar {

/// Motion of the bodies in a step h per unit of force: h B^-1, B = diag(b I, b_t I, b_o I). A spring k that pulls a
/// body adds h k to its viscosity, for it is taken at the end of the step.
struct Mobility {
  double joint;        ///< [rad/(N m)]
  double translation;  ///< [m/N]
  double rotation;     ///< [rad/(N m)]
  /// Joints that differ have the mobility joint root_j^2, one that is stopped none. Empty: all are 1.
  JointVector root = {};
  /// B of each finger where joints have stiffness, b I + h K [N m s], without joints at their stops, and some L with
  /// h B^-1 = joint L L', zero for these. Else empty: then the above suffices.
  PerFinger<JointMatrix> damping = {}, factor = {};

  [[nodiscard]] bool is_stiff() const { return factor.size() > 0; }

  [[nodiscard]] double of_joint(Eigen::Index j) const { return root.size() == 0 ? joint : joint * root[j] * root[j]; }
};

/// Returns the scene's mobility, with the stiffness of the springs on each joint [N m/rad].
[[nodiscard]] Mobility mobility(const Scene& scene, double joint_stiffness = 0.0);

/// Gives each finger's joints a stiffness K [N m/rad] besides the scene's viscosity: see Mobility::factor.
void add_stiffness(const Scene& scene, const PerFinger<JointMatrix>& stiffness, Mobility& mobility);

/// Returns L of a finger, for its B and its free joints.
[[nodiscard]] JointMatrix mobility_factor(const JointMatrix& damping, double mobility_per_joint, double step_s,
                                          const std::array<bool, kMaxFingerJoints>& free);

/// Returns h B^-1 tau [rad].
[[nodiscard]] JointVector joint_motion(const Hand& hand, const Mobility& mobility, const JointVector& torque_Nm);

/// Computes the inputs of the operators below where fingers differ: J_mobile, from the roots of a mobility that has
/// them, and the gain in a step of the pulps of a hand with several materials.
void set_shares(const Model& model, const Frame& frame, const Mobility& mobility, ContactKinematics& kinematics);

/// Returns W(h) = J_c h B^-1 J_c' + (1 - rho) C of eqs. (31, 36): the Delassus operator of a step h, in factors [m/N].
/// The operator refers to the frame and the kinematics, whose shares belong to this mobility.
[[nodiscard]] GroupedDelassus delassus_operator(const Model& model, const Frame& frame,
                                                const ContactKinematics& kinematics, const Mobility& mobility);

/// Returns the same as one matrix, 3n x 3n, with (1 - rho_o) C_o of a soft object. Takes memory for it.
[[nodiscard]] Eigen::MatrixXd dense_delassus(const Model& model, const Frame& frame,
                                             const ContactKinematics& kinematics, const Mobility& mobility);

/// Adds dq += h B^-1 J_c' f: the motion of joints by contact forces, as a solve left it.
void add_joint_motion(const Hand& hand, const Mobility& mobility, const GroupedWorkspace& solve, JointVector& dq);

}  // namespace thenar
