// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "thenar/eigen_layout.h"

namespace thenar {

/// Largest number of contacts of a grasp-force problem (one a finger).
inline constexpr Eigen::Index kMaxGraspContacts = 8;

using Vector6d = Eigen::Matrix<double, 6, 1>;

/// A finger's contact point and axes on the object.
struct GraspContact {
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();  ///< Contact point, world axes.
  Eigen::Matrix3d axes = Eigen::Matrix3d::Zero();     ///< Columns n, t1, t2 in world axes; n points into the object.
};

/// Friction and internal force of one contact.
struct ContactGrip {
  double friction = 0.0;          ///< mu_c of its cone.
  double internal_force_N = 0.0;  ///< Its lambda of eq. (13).
};

/// The friction cone of a contact.
enum class FrictionCone {
  kPyramid,  ///< |f_t1|, |f_t2| <= mu f_n: circumscribed about Coulomb's cone [9].
  kExact,    ///< |f_t| <= mu f_n.
};

/// A grasp-force problem: find the least forces inside friction cones that give `wrench`, biased by an internal force.
struct GraspProblem {
  std::span<const GraspContact> contacts;              ///< At most kMaxGraspContacts.
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();  ///< The point that torques are taken about.
  Vector6d wrench = Vector6d::Zero();                  ///< W^d on the object: force [N], torque [N m], world axes.
  double friction = 0.0;                               ///< mu_c of the cone.
  FrictionCone cone = FrictionCone::kPyramid;
  double internal_force_N = 0.0;  ///< lambda of eq. (13).
  /// One per contact, in place of `friction` and `internal_force_N`; if empty, these hold for all contacts.
  std::span<const ContactGrip> grips = {};

  [[nodiscard]] double friction_of(Eigen::Index i) const { return grips.empty() ? friction : grips[i].friction; }
  [[nodiscard]] double internal_force_of(Eigen::Index i) const {
    return grips.empty() ? internal_force_N : grips[i].internal_force_N;
  }
};

/// A grasp-force problem that owns its contacts, for either cone; see GraspProblem.
struct GraspData {
  std::vector<GraspContact> contacts;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  Vector6d wrench = Vector6d::Zero();
  double friction = 0.0;
  double internal_force_N = 0.0;
  std::vector<ContactGrip> grips = {};  ///< One a contact, or empty.

  [[nodiscard]] GraspProblem problem(FrictionCone cone) const {
    return {contacts, centre_m, wrench, friction, cone, internal_force_N, grips};
  }
};

/// Outcome of a grasp-force problem.
enum class GraspStatus {
  kOptimal,
  kInfeasible,   ///< No forces inside the cones give the wrench, or none below 1e8 times the least without cones.
  kBudgetSpent,  ///< No answer: the pivots ran out, the input was not finite, or rounding spoiled the result.
};

}  // namespace thenar
