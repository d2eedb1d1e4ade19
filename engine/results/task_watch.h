// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>

#include "engine/results/recording.h"
#include "engine/results/task_results.h"

namespace thenar {

/// Watches the task of a scene: its phases, which know what a hand can know, and what they do not know: whether the
/// object stays where it was let go, and comes to its goal. All poses are against the environment, as if the arm had
/// stood still.
class TaskWatch {
 public:
  explicit TaskWatch(const Model& model);

  /// Adds a control tick's state of the task.
  void add(const TaskReport& task);
  /// Adds a contact tick.
  void add(const TickRecord& tick);

  /// Returns true if a phase has failed.
  [[nodiscard]] bool has_failed() const { return task_.has_failed; }
  /// Returns the number of the running phase; -1: none runs.
  [[nodiscard]] int phase() const { return is_done() ? -1 : task_.phase; }
  /// Returns true if all phases are done.
  [[nodiscard]] bool is_done() const;
  /// Returns in words which body resists an arm that carries the object; empty if none does.
  [[nodiscard]] std::string resistance() const;
  /// Returns why the task is not done, in words; empty if it is, or if there is none. `is_over`: the run has come to
  /// its end, where it must be.
  [[nodiscard]] std::string failure(bool is_over) const;

  /// For an archive (engine/loops/archive.h).
  template <typename Archive>
  void members(Archive& a) {
    a(task_, failed_body_N_, body_N_, X_EO_, now_s_, let_go_, let_go_s_, gone_s_, rest_X_EO_, rest_since_s_, borne_N_);
  }

 private:
  [[nodiscard]] bool has_gone() const;
  [[nodiscard]] std::string unrest_in_words() const;
  [[nodiscard]] std::string missed_goal_in_words() const;

  const Model& model_;
  int last_release_ = -1;  ///< Number of the phase after which nothing holds the object; -1: none.
  TaskReport task_;
  BodyForces failed_body_N_ = BodyForces::Zero();  ///< Forces when a phase failed.
  BodyForces body_N_ = BodyForces::Zero();
  Eigen::Isometry3d X_EO_ = Eigen::Isometry3d::Identity();  ///< Pose of the object now.
  double now_s_ = 0.0;
  std::optional<Eigen::Isometry3d> let_go_;  ///< Pose when the last release began.
  double let_go_s_ = 0.0;
  std::optional<double> gone_s_;                                 ///< Time at which it was first out of its place.
  Eigen::Isometry3d rest_X_EO_ = Eigen::Isometry3d::Identity();  ///< A pose near which the object has been since then.
  double rest_since_s_ = 0.0;
  double borne_N_ = 0.0;  ///< What the environment bears.
};

}  // namespace thenar
