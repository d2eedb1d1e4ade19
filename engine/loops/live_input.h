// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>

#include "engine/grasp/contact_tick.h"
#include "engine/grasp/model.h"
#include "engine/grasp/state.h"
#include "engine/loops/picture.h"

namespace thenar {

/// The user's live input to a running grasp; the contact loop uses the newest.
struct LiveInput {
  /// A spring from a point of the object to a handle.
  struct Pull {
    Eigen::Vector3d point_O;   ///< Object frame [m].
    Eigen::Vector3d handle_W;  ///< World [m].
  };

  std::int64_t number = 0;         ///< Number of the input, which identifies new ones. 0: there was none.
  std::int64_t stamp_ns = 0;       ///< Time of its creation by the device, steady clock.
  std::int64_t pull_heard_ns = 0;  ///< Last time at which the pull was confirmed: the dead man's clock.
  std::optional<Pull> pull;
  Vector6d wrench =
      Vector6d::Zero();    ///< On the object, about its origin, world axes [N, N m]; from a program, unlimited.
  std::int64_t pokes = 0;  ///< Number of pokes so far: an increase begins one.
  Eigen::Vector3d poke_N = Eigen::Vector3d::Zero();
  Eigen::Vector3d target_shift_m = Eigen::Vector3d::Zero();   ///< Shift of the task's target, object axes at the start.
  Eigen::Vector3d target_turn_rad = Eigen::Vector3d::Zero();  ///< Rotation vector of the target, likewise.
};

// Stiffness and limit of the spring: soft enough to be held by a grip of some N, and at most a finger's push.
inline constexpr double kPullStiffness_N_per_m = 100.0, kPullLimit_N = 2.0;
inline constexpr double kDeadMan_s = 0.2;  ///< A pull that is not confirmed for this time is released.
inline constexpr double kPoke_s = 0.03, kPokeLimit_N = 5.0;
inline constexpr double kShiftLimit_m = 0.05, kTurnLimit_rad = 0.5;  ///< Limits of the target's shift, for each axis.
/// Speeds of the target's shift. A target at 0.1 m/s leads the box of configs/box_grasp.yaml by 6 to 8 mm with control
/// at 200 Hz, and 10 mm are a loss.
inline constexpr double kShiftSpeed_m_per_s = 0.05, kTurnSpeed_rad_per_s = 1.0;

/// The conversion of live input to a contact tick's input, in the contact loop at its rate. For any input the wrench is
/// finite and bounded, as are the target's speed and distance: values that are not finite are ignored, large ones are
/// clamped.
class LiveHands {
 public:
  explicit LiveHands(const Model& model) : model_(model) {}

  /// Returns the input of the next tick on `state`, at `now_ns` of the steady clock. Does not allocate, lock or throw.
  [[nodiscard]] TickInput next(const LiveInput& input, const State& state, std::int64_t now_ns) noexcept;

  /// Returns the spring that acted in that tick.
  [[nodiscard]] const std::optional<ShownPull>& pull() const { return pull_; }

  /// Releases the pull and restores the task's target. Pokes up to now are over.
  void reset(const LiveInput& newest) noexcept;

 private:
  [[nodiscard]] std::optional<ShownPull> find_pull(const LiveInput& input, const State& state,
                                                   std::int64_t now_ns) const noexcept;
  [[nodiscard]] Eigen::Vector3d poke(const LiveInput& input) noexcept;
  [[nodiscard]] std::optional<Eigen::Isometry3d> move_target(const LiveInput& input, double time_s) noexcept;

  const Model& model_;
  std::optional<ShownPull> pull_;
  std::int64_t pokes_ = 0;
  double poke_s_ = kPoke_s;  ///< Time since the last one began.
  Eigen::Vector3d poke_N_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d shift_m_ = Eigen::Vector3d::Zero(), turn_rad_ = Eigen::Vector3d::Zero();
};

}  // namespace thenar
