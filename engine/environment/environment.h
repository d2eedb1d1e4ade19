// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
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

/// A rigid body that the object may touch, with prescribed motion. World = hand frame: a table that moves down
/// represents an arm that lifts.
struct EnvironmentBody {
  std::string name;
  Solid shape;
  Eigen::Isometry3d X_WE = Eigen::Isometry3d::Identity();  ///< Pose at the start.
  double friction = 0.0;                                   ///< Coulomb's coefficient against the object.
  std::vector<EnvironmentMove> moves;                      ///< Moves; they are superposed.
  /// Gap below the object that stands on it, until its pose follows from that: see stand_object(). Nothing: X_WE holds.
  std::optional<double> under_gap_m = {};
};

/// The environment: all bodies around the object other than the hand.
struct Environment {
  std::vector<EnvironmentBody> bodies;
  double compliance_m_per_N = 0.0;  ///< Compliance of each contact, the same in all directions; > 0.
  std::string place = {};           ///< Place in its file, for messages: "file:line:column".
  /// Poses and moves of bodies are in the object's frame at the start, until its pose is known: see place_by_object().
  bool in_object_frame = false;
};

/// A commanded minimum-jerk displacement of the arm that carries the hand, world axes; zero: it stops.
struct ArmOrder {
  std::int64_t number = 0;  ///< Increases by one with each order; 0: none yet.
  Eigen::Vector3d by_m = Eigen::Vector3d::Zero();
  double over_s = 1.0;
};

/// The motion of the arm. The world is the hand's frame, so the environment moves in the opposite direction.
struct ArmWay {
  std::int64_t order = 0;                            ///< Number of its order.
  Eigen::Vector3d from_m = Eigen::Vector3d::Zero();  ///< Position of the arm at its begin, relative to the run's start.
  Eigen::Vector3d by_m = Eigen::Vector3d::Zero();
  double begin_s = 0.0;
  double over_s = 1.0;
};
/// Returns the position of the arm, relative to the run's start.
[[nodiscard]] Eigen::Vector3d arm_m(const ArmWay& way, double time_s);
/// Starts the motion of a new order from the arm's position now, however late the order comes.
void follow(const ArmOrder& order, double now_s, ArmWay& way);

/// A time, and the arm's position then.
struct Instant {
  // NOLINTNEXTLINE(google-explicit-constructor): without an arm an instant is a time.
  Instant(double t_s, const Eigen::Vector3d& arm = Eigen::Vector3d::Zero()) : time_s(t_s), arm_m(arm) {}

  double time_s;
  Eigen::Vector3d arm_m;
};
[[nodiscard]] inline Instant instant(const ArmWay& way, double time_s) { return {time_s, arm_m(way, time_s)}; }

[[nodiscard]] Eigen::Isometry3d pose(const EnvironmentBody& body, const Instant& at);

}  // namespace thenar
