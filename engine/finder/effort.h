#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <limits>
#include <vector>

#include "engine/finder/found_grasp.h"
#include "engine/hand/hand.h"
#include "solvers/grasp_problem.h"

namespace thenar {

/// What a grasp is to bear beside the weight: a push in any direction, and a turn.
inline constexpr double kPush_N = 0.5, kTurn_Nm = 10e-3;

/// Along the axes and the diagonals of a cube: unit vectors in 14 directions.
[[nodiscard]] std::vector<Eigen::Vector3d> directions();

/// Forces that the controller asks for.
struct HoldingForces {
  bool found = false;
  Eigen::VectorXd f;             ///< On the object, finger by finger, world axes; 0 if not found.
  double needed_friction = 0.0;  ///< Largest |f_t| / f_n of a contact; infinite if not found.
};

/// Forces that the controller would ask for against an outer force at the centre of mass and a moment, world axes.
/// It refers to the contacts.
class ForceCheck {
 public:
  ForceCheck(const FinderProblem& problem, const std::vector<GraspContact>& contacts, const Eigen::Isometry3d& X_WO,
             double internal_force_N);
  [[nodiscard]] HoldingForces against(const Eigen::Vector3d& force_N, const Eigen::Vector3d& moment_Nm);
  /// The moment about the centre of mass of a force at the origin of the object's frame.
  [[nodiscard]] Eigen::Vector3d moment_at_origin_Nm(const Eigen::Vector3d& force_N) const {
    return -lever_m_.cross(force_N);
  }

 private:
  const std::vector<GraspContact>& contacts_;
  Eigen::Vector3d lever_m_;
  GraspProblem problem_;
};

/// What joints and muscles give while the fingers press with some forces at their contacts. It refers to them.
class Effort {
 public:
  Effort(const FinderProblem& problem, const Hand& hand, const std::vector<GraspContact>& contacts)
      : problem_(problem), hand_(hand), contacts_(contacts) {}

  /// J' f + g at q.
  [[nodiscard]] JointVector torques_Nm(const JointVector& q, const Eigen::VectorXd& f);
  /// The largest force of a muscle over its limit for the torques at the pose of the last torques_Nm(); 0 without any.
  [[nodiscard]] double muscle_share(const JointVector& tau);

 private:
  const FinderProblem& problem_;
  const Hand& hand_;
  const std::vector<GraspContact>& contacts_;
  HandPose pose_;
};

}  // namespace thenar
