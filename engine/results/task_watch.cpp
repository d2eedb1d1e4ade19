// SPDX-License-Identifier: Apache-2.0
#include "engine/results/task_watch.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/grasp/state.h"

namespace thenar {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Kind = Phase::Kind;

namespace {

// What was let go has stayed if it is so near to where it was.
constexpr double kStays_m = 2e-3, kStays_rad = 5.0 / kDegrees;
// It rests if it has moved less than this in so long: at 1 mm/s, and what a radius of 25 mm makes of that.
constexpr double kRest_s = 0.2, kRest_m = 0.2e-3, kRest_rad = 8e-3;
constexpr double kBorne = 0.9;  // Share of its weight that the environment must bear.

double distance_m(const Isometry3d& from, const Isometry3d& to) {
  return (to.translation() - from.translation()).norm();
}

double angle_rad(const Isometry3d& from, const Isometry3d& to) { return pose_error(to, from).tail<3>().norm(); }

}  // namespace

TaskWatch::TaskWatch(const Model& model) : model_(model) {
  const auto& phases = model.scene.task.phases;
  for (int i = static_cast<int>(phases.size()) - 1; i >= 0; --i) {
    const Kind kind = phases[static_cast<std::size_t>(i)].kind;
    if (kind == Kind::kRelease) last_release_ = i;
    if (kind != Kind::kApproach) break;
  }
}

bool TaskWatch::is_done() const { return task_.phase >= 0 && task_.phase == std::ssize(model_.scene.task.phases); }

void TaskWatch::add(const TaskReport& task) {
  if (task_.has_failed) return;
  task_ = task;
  if (task_.has_failed) failed_body_N_ = body_N_;
}

void TaskWatch::add(const TickRecord& tick) {
  const Scene& scene = model_.scene;
  if (scene.task.phases.empty() && !scene.task.goal) return;
  now_s_ = tick.time_s;
  body_N_ = tick.contact.environment.body_N;
  borne_N_ = -scene.gravity.normalized().dot(tick.contact.environment.wrench.head<3>());
  X_EO_ = tick.X_WO;
  X_EO_.translation() += scene.object.X_WO.linear() * tick.arm_m;
  if (last_release_ < 0 || tick.phase < last_release_) return;
  if (!let_go_) {
    let_go_ = rest_X_EO_ = X_EO_;
    let_go_s_ = rest_since_s_ = now_s_;
  }
  if (has_gone() && !gone_s_) gone_s_ = now_s_;
  if (distance_m(rest_X_EO_, X_EO_) > kRest_m || angle_rad(rest_X_EO_, X_EO_) > kRest_rad) {
    rest_X_EO_ = X_EO_;
    rest_since_s_ = now_s_;
  }
}

bool TaskWatch::has_gone() const {
  return let_go_ && (distance_m(*let_go_, X_EO_) > kStays_m ||
                     turn_rad(model_.scene.object.shape, let_go_->linear(), X_EO_.linear()) > kStays_rad);
}

std::string TaskWatch::resistance() const {
  const auto& phases = model_.scene.task.phases;
  if (task_.phase < 0 || is_done() || body_N_.isZero(0.0)) return "";
  const Kind kind = phases[static_cast<std::size_t>(task_.phase)].kind;
  const bool carries = kind == Kind::kLift || kind == Kind::kMove || kind == Kind::kInsert;
  return carries ? resistance_in_words(model_.scene, body_N_) : "";
}

/// Of an object that was let go and does not stay, or does not rest yet.
std::string TaskWatch::unrest_in_words() const {
  if (has_gone()) {
    const double turn = turn_rad(model_.scene.object.shape, let_go_->linear(), X_EO_.linear());
    const double far_m = distance_m(*let_go_, X_EO_);
    const double down_m = model_.scene.gravity.normalized().dot(X_EO_.translation() - let_go_->translation());
    const char* const how = down_m > std::max(kStays_m, 0.5 * far_m)  ? "fell"
                            : turn > kStays_rad                       ? "tipped over"
                            : angle_rad(*let_go_, X_EO_) > kStays_rad ? "rolled"
                                                                      : "slid";
    return fmt::format(
        "the object {} after it was let go at {:.3f} s, from {:.3f} s on: at {:.3f} s it is {:.1f} mm "
        "from there, {:.1f} mm of them down, and turned by {:.0f} degrees",
        how, let_go_s_, gone_s_.value_or(now_s_), now_s_, 1e3 * far_m, 1e3 * down_m, kDegrees * turn);
  }
  if (!is_done()) return "";  // A phase that goes on comes first.
  if (now_s_ - rest_since_s_ < kRest_s) {
    return fmt::format("the object, let go at {:.3f} s, does not rest yet at {:.3f} s", let_go_s_, now_s_);
  }
  const double weight_N = model_.scene.object.mass_kg * model_.scene.gravity.norm();
  if (borne_N_ >= kBorne * weight_N) return "";
  return fmt::format("what is under the object bears {:.3g} N of its {:.3g} N at {:.3f} s", borne_N_, weight_N, now_s_);
}

std::string TaskWatch::missed_goal_in_words() const {
  const TaskGoal& goal = *model_.scene.task.goal;
  std::string missed;
  if (goal.position_m) {
    const double off_m = (X_EO_.translation() - *goal.position_m).norm();
    if (!(off_m <= goal.within_m)) {
      missed = fmt::format("{:.1f} mm from its goal's position, of {:g} mm at most", 1e3 * off_m, 1e3 * goal.within_m);
    }
  }
  if (goal.rotation) {
    const double off_rad = turn_rad(model_.scene.object.shape, *goal.rotation, X_EO_.linear());
    if (!(off_rad <= goal.within_rad)) {
      missed += fmt::format("{}{:.1f} degrees from its goal's rotation, of {:g} at most", missed.empty() ? "" : " and ",
                            kDegrees * off_rad, kDegrees * goal.within_rad);
    }
  }
  return missed.empty() ? missed : fmt::format("at {:.3f} s the object is {}", now_s_, missed);
}

std::string TaskWatch::failure(bool is_over) const {
  std::string all;
  const auto add = [&](const std::string& what) {
    if (!what.empty()) all += (all.empty() ? "" : "; ") + what;
  };
  const Scene& scene = model_.scene;
  if (let_go_ && (is_over || task_.has_failed)) add(unrest_in_words());
  if (task_.has_failed) {
    add(in_words(scene, task_, failed_body_N_));
  } else if (is_over && task_.phase >= 0 && !is_done()) {
    add(fmt::format("its time was over at {:.3f} s in {}", now_s_, in_words(scene, task_, body_N_)));
  }
  if (is_over && scene.task.goal) add(missed_goal_in_words());
  return all;
}

}  // namespace thenar
