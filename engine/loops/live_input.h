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

/// What someone's hands ask of a running grasp, the newest of which the contact loop acts on.
struct LiveInput {
  /// A spring from a point of the object to a place.
  struct Pull {
    Eigen::Vector3d point_O;   ///< Object frame [m].
    Eigen::Vector3d handle_W;  ///< World [m].
  };

  std::int64_t number = 0;         ///< Of the input: a new one is acted on for the first time. 0: there was none.
  std::int64_t stamp_ns = 0;       ///< When the device made it, steady clock.
  std::int64_t pull_heard_ns = 0;  ///< When the pull was last heard of: the dead man's clock.
  std::optional<Pull> pull;
  Vector6d wrench =
      Vector6d::Zero();    ///< On the object, about its origin, world axes [N, N m]: of a program, unlimited.
  std::int64_t pokes = 0;  ///< How many there have been: one more begins one.
  Eigen::Vector3d poke_N = Eigen::Vector3d::Zero();
  Eigen::Vector3d target_shift_m = Eigen::Vector3d::Zero();   ///< Off the task's target, object axes at the start.
  Eigen::Vector3d target_turn_rad = Eigen::Vector3d::Zero();  ///< Rotation vector, likewise.
};

// Of the spring: soft enough for a grip of some N to hold against it, and never more than a push of a finger.
inline constexpr double kPullStiffness_N_per_m = 100.0, kPullLimit_N = 2.0;
inline constexpr double kDeadMan_s = 0.2;  ///< A pull of which nothing more is heard for so long lets go.
inline constexpr double kPoke_s = 0.03, kPokeLimit_N = 5.0;
inline constexpr double kShiftLimit_m = 0.05, kTurnLimit_rad = 0.5;  ///< Of the target, each axis,
/// and how fast it goes there. A target at 0.1 m/s leaves the box of configs/box_grasp.yaml 6 to 8 mm behind with
/// control at 200 Hz, and 10 mm are a loss.
inline constexpr double kShiftSpeed_m_per_s = 0.05, kTurnSpeed_rad_per_s = 1.0;

/// Makes of live input what a contact tick takes: held by the contact loop, at its own rate. Whatever hands say, the
/// wrench is finite and bounded, and the target's speed and distance are: what is not finite is left out, what is too
/// much is cut.
class LiveHands {
 public:
  explicit LiveHands(const Model& model) : model_(model) {}

  /// For the next tick on `state`, at `now_ns` of the steady clock. Does not allocate, lock or throw.
  [[nodiscard]] TickInput next(const LiveInput& input, const State& state, std::int64_t now_ns) noexcept;

  /// The spring as it acted in that tick.
  [[nodiscard]] const std::optional<ShownPull>& pull() const { return pull_; }

  /// Lets go, and the target is the task's again. Pokes up to now are over.
  void reset(const LiveInput& newest) noexcept;

 private:
  [[nodiscard]] std::optional<ShownPull> find_pull(const LiveInput& input, const State& state,
                                                   std::int64_t now_ns) const noexcept;
  [[nodiscard]] Eigen::Vector3d poke(const LiveInput& input) noexcept;
  [[nodiscard]] std::optional<Eigen::Isometry3d> move_target(const LiveInput& input, double time_s) noexcept;

  const Model& model_;
  std::optional<ShownPull> pull_;
  std::int64_t pokes_ = 0;
  double poke_s_ = kPoke_s;  ///< Since the last one began.
  Eigen::Vector3d poke_N_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d shift_m_ = Eigen::Vector3d::Zero(), turn_rad_ = Eigen::Vector3d::Zero();
};

}  // namespace thenar
