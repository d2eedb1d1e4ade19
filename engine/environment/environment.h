#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "collision/solids/solid.h"

namespace thenar {

/// A minimum-jerk move of a body of the environment, world axes.
struct EnvironmentMove {
  Eigen::Vector3d by_m = Eigen::Vector3d::Zero();
  double from_s = 0.0;
  double over_s = 1.0;
};

/// A rigid body that the object may touch, and that moves as it is told to. World = hand frame: a table that moves down
/// is an arm that lifts.
struct EnvironmentBody {
  std::string name;
  Solid shape;
  Eigen::Isometry3d X_WE = Eigen::Isometry3d::Identity();  ///< At the start.
  double friction = 0.0;                                   ///< Coulomb's coefficient against the object.
  std::vector<EnvironmentMove> moves;                      ///< They add up.
};

/// What is around the object beside the hand.
struct Environment {
  std::vector<EnvironmentBody> bodies;
  double compliance_m_per_N = 0.0;  ///< How object and bodies give way at each contact, in all directions; > 0.
  std::string place = {};           ///< In its file, for refusals: "file:line:column".
};

[[nodiscard]] Eigen::Isometry3d pose(const EnvironmentBody& body, double time_s);

/// The part of a minimum-jerk move that is done after a part s of its time: from 0 to 1 with no velocity and
/// acceleration at both ends [Flash, Hogan 1985]. Before and after it stays.
[[nodiscard]] double minimum_jerk(double s);

}  // namespace thenar
