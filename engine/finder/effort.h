// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <limits>
#include <vector>

#include "engine/finder/found_grasp.h"
#include "engine/hand/hand.h"
#include "solvers/grasp_problem.h"

namespace thenar {

/// Disturbances that a grasp must bear besides the weight: a push in any direction, and a torque.
inline constexpr double kPush_N = 0.5, kTurn_Nm = 10e-3;

/// Returns unit vectors in 14 directions, along the axes and the diagonals of a cube.
[[nodiscard]] std::vector<Eigen::Vector3d> directions();

/// Forces that the controller commands.
struct HoldingForces {
  bool found = false;
  Eigen::VectorXd f;             ///< Forces on the object, finger by finger, world axes; 0 if not found.
  double needed_friction = 0.0;  ///< Largest |f_t| / f_n of a contact; infinite if not found.
};

/// The computation of the forces that the controller would command against an outer force at the centre of mass and a
/// moment, world axes. It keeps a reference to the contacts.
class ForceCheck {
 public:
  ForceCheck(const FinderProblem& problem, const std::vector<GraspContact>& contacts, const Eigen::Isometry3d& X_WO,
             double internal_force_N);
  [[nodiscard]] HoldingForces against(const Eigen::Vector3d& force_N, const Eigen::Vector3d& moment_Nm);
  /// Returns the moment about the centre of mass of a force at the origin of the object's frame.
  [[nodiscard]] Eigen::Vector3d moment_at_origin_Nm(const Eigen::Vector3d& force_N) const {
    return -lever_m_.cross(force_N);
  }

 private:
  const std::vector<GraspContact>& contacts_;
  Eigen::Vector3d lever_m_;
  GraspProblem problem_;
};

/// The effort of joints and muscles by contact forces of the fingers and by gravity, with the object at X_WO. It keeps
/// references to its other arguments.
class Effort {
 public:
  Effort(const FinderProblem& problem, const Hand& hand, const std::vector<GraspContact>& contacts,
         const Eigen::Isometry3d& X_WO)
      : problem_(problem), hand_(hand), contacts_(contacts), gravity_(problem.gravity_at(X_WO)) {}

  /// Computes J' f + g at q.
  [[nodiscard]] JointVector torques_Nm(const JointVector& q, const Eigen::VectorXd& f);
  /// Computes the largest force of a muscle over its limit for the torques at the pose of the last torques_Nm(); 0
  /// without muscles.
  [[nodiscard]] double muscle_share(const JointVector& tau);

 private:
  const FinderProblem& problem_;
  const Hand& hand_;
  const std::vector<GraspContact>& contacts_;
  Eigen::Vector3d gravity_;
  HandPose pose_;
};

}  // namespace thenar
