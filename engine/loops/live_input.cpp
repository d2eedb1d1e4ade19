// SPDX-License-Identifier: Apache-2.0
#include "engine/loops/live_input.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace thenar {

using Eigen::Isometry3d;
using Eigen::Vector3d;

namespace {

/// Returns the vector, limited to that length; zero if its length overflows.
Vector3d cut(const Vector3d& v, double longest) { return v * std::min(1.0, longest / v.stableNorm()); }

/// Moves from `from` towards `to`, by `step` at most.
Vector3d approach(const Vector3d& from, const Vector3d& to, double step) { return from + cut(to - from, step); }

/// Returns the requested shift of the target, each axis within the limit; unchanged if not finite.
Vector3d goal(const Vector3d& wanted, const Vector3d& now, double limit) {
  return wanted.allFinite() ? Vector3d(wanted.cwiseMax(-limit).cwiseMin(limit)) : now;
}

Eigen::AngleAxisd turn_of(const Vector3d& rotation) {
  const double angle = rotation.norm();
  return {angle, angle > 0.0 ? Vector3d(rotation / angle) : Vector3d::UnitX()};
}

}  // namespace

TickInput LiveHands::next(const LiveInput& input, const State& state, std::int64_t now_ns) noexcept {
  TickInput tick;
  pull_ = find_pull(input, state, now_ns);
  if (pull_) {
    tick.wrench.head<3>() = pull_->force_N;
    tick.wrench.tail<3>() = (pull_->anchor_m - state.X_WO.translation()).cross(pull_->force_N);
  }
  tick.wrench.head<3>() += poke(input);
  if (input.wrench.allFinite()) tick.wrench += input.wrench;
  tick.X_WT = move_target(input, static_cast<double>(state.tick + 1) * model_.scene.step_s);
  return tick;
}

void LiveHands::reset(const LiveInput& newest) noexcept {
  pull_.reset();
  pokes_ = newest.pokes;
  poke_s_ = kPoke_s;
  shift_m_.setZero();
  turn_rad_.setZero();
}

std::optional<ShownPull> LiveHands::find_pull(const LiveInput& input, const State& state,
                                              std::int64_t now_ns) const noexcept {
  if (!input.pull || !input.pull->point_O.allFinite() || !input.pull->handle_W.allFinite()) return std::nullopt;
  // In double, where the difference of any two numbers is one. A clock that is ahead by more is none.
  const double age_s = 1e-9 * (static_cast<double>(now_ns) - static_cast<double>(input.pull_heard_ns));
  if (std::abs(age_s) > kDeadMan_s) return std::nullopt;
  const Scene& scene = model_.scene;
  // The spring holds the object itself: points outside it have no lever.
  const Eigen::AlignedBox3d& box = model_.object.bounds();
  const Vector3d arm = state.X_WO.linear() * input.pull->point_O.cwiseMax(box.min()).cwiseMin(box.max());
  // The force is that at the tick's start: a spring that could move its anchor past the handle in one tick, on a free
  // object, would oscillate. No scene of ours comes near that.
  const double mobility = scene.step_s * (1.0 / scene.object.translation_damping +
                                          arm.squaredNorm() / scene.object.rotation_damping);  // of the anchor [m/N]
  const double stiffness = std::min(kPullStiffness_N_per_m, 1.0 / mobility);
  const Vector3d anchor = state.X_WO.translation() + arm;
  const Vector3d way = input.pull->handle_W - anchor;
  return ShownPull{anchor, input.pull->handle_W, stiffness * cut(way, kPullLimit_N / stiffness)};
}

Vector3d LiveHands::poke(const LiveInput& input) noexcept {
  if (input.pokes > pokes_) {
    poke_N_ = input.poke_N.allFinite() ? cut(input.poke_N, kPokeLimit_N) : Vector3d::Zero();
    poke_s_ = 0.0;
  }
  pokes_ = std::max(pokes_, input.pokes);
  if (poke_s_ >= kPoke_s) return Vector3d::Zero();
  // At the tick's middle: ticks as long as the poke itself still push.
  const double time_s = poke_s_ + 0.5 * model_.scene.step_s;
  poke_s_ += model_.scene.step_s;
  return std::max(0.0, std::sin(std::numbers::pi * time_s / kPoke_s)) * poke_N_;
}

std::optional<Isometry3d> LiveHands::move_target(const LiveInput& input, double time_s) noexcept {
  const double step_s = model_.scene.step_s;
  shift_m_ = approach(shift_m_, goal(input.target_shift_m, shift_m_, kShiftLimit_m), kShiftSpeed_m_per_s * step_s);
  turn_rad_ =
      approach(turn_rad_, goal(input.target_turn_rad, turn_rad_, kTurnLimit_rad), kTurnSpeed_rad_per_s * step_s);
  if (shift_m_.isZero(0.0) && turn_rad_.isZero(0.0)) return std::nullopt;
  const Eigen::Matrix3d& axes = model_.scene.object.X_WO.linear();
  Isometry3d X_WT = model_.target(time_s);
  X_WT.translation() += axes * shift_m_;
  X_WT.linear() = axes * turn_of(turn_rad_) * axes.transpose() * X_WT.linear();
  return X_WT;
}

}  // namespace thenar
