#pragma once

#include <Eigen/Geometry>
#include <cstdint>
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

/// Where the arm that carries the hand is to go from where it is, by a minimum-jerk way, world axes. By nothing: it
/// stops.
struct ArmOrder {
  std::int64_t number = 0;  ///< Rises by one with each; 0: none yet.
  Eigen::Vector3d by_m = Eigen::Vector3d::Zero();
  double over_s = 1.0;
};

/// How the arm goes. The world is the hand's frame, and so what is around the object goes the other way.
struct ArmWay {
  std::int64_t order = 0;                            ///< Its number.
  Eigen::Vector3d from_m = Eigen::Vector3d::Zero();  ///< Where the arm was as it began, against the run's start.
  Eigen::Vector3d by_m = Eigen::Vector3d::Zero();
  double begin_s = 0.0;
  double over_s = 1.0;
};
/// Where the arm is, against the run's start.
[[nodiscard]] Eigen::Vector3d arm_m(const ArmWay& way, double time_s);
/// An order that is new begins where the arm is now, however late it comes.
void follow(const ArmOrder& order, double now_s, ArmWay& way);

/// A time, and where the arm is then.
struct Instant {
  // NOLINTNEXTLINE(google-explicit-constructor): without an arm an instant is a time.
  Instant(double t_s, const Eigen::Vector3d& arm = Eigen::Vector3d::Zero()) : time_s(t_s), arm_m(arm) {}

  double time_s;
  Eigen::Vector3d arm_m;
};
[[nodiscard]] inline Instant instant(const ArmWay& way, double time_s) { return {time_s, arm_m(way, time_s)}; }

[[nodiscard]] Eigen::Isometry3d pose(const EnvironmentBody& body, const Instant& at);

}  // namespace thenar
