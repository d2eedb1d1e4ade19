// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "engine/control/grasp_stiffness.h"
#include "thenar/eigen_layout.h"

namespace thenar {

/// The compliance of an object, its own axes.
struct SlippingCompliance {
  Matrix6d C_O;
  bool is_solved =
      true;  ///< False if the LCP of a push has no solution, which friction may bring about: there contacts
             ///< stick in C_O, and the grasp may give way.
};

/// Returns the object's compliance about its origin, its own axes, of a grasp some of whose contacts are at their
/// cones' edge: one may stick under a push and slip under the opposite one, so the columns are the mean of both.
/// Solves for each push the LCP that FingerSlips states, with joints and object in equilibrium.
///
/// sticking, slips  By sticking_stiffness().
/// muscles          Stiffness of each finger's muscles [N m/rad].
/// R_WO             Attitude of the object.
[[nodiscard]] SlippingCompliance slipping_compliance(const GraspStiffness& sticking,
                                                     const PerFinger<FingerSlips>& slips,
                                                     const PerFinger<JointMatrix>& muscles,
                                                     const Eigen::Matrix3d& R_WO);

}  // namespace thenar
