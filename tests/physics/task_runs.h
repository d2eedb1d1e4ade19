// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "engine/models/build_model.h"
#include "engine/results/scene_run.h"
#include "engine/results/summary.h"
#include "tests/support/scenes.h"

namespace thenar::task_test {

/// Where the arm was after each tick.
class ArmWatcher : public Watcher {
 public:
  explicit ArmWatcher(double step_s) : step_s_(step_s) {}
  bool see_tick(const Tick& tick) override {
    arms_m.push_back(arm_m(tick.after.arm, static_cast<double>(tick.after.tick) * step_s_));
    phases.push_back(tick.control.task.phase);
    ticks.push_back(tick.after.tick);
    return true;
  }
  std::vector<Eigen::Vector3d> arms_m;
  std::vector<int> phases;
  std::vector<std::int64_t> ticks;

 private:
  double step_s_;
};

struct TaskOf {
  explicit TaskOf(const std::string& name, const std::vector<std::string>& overrides = {},
                  std::optional<LockstepSettings> lockstep = {})
      : TaskOf(scene_of(name, overrides), std::move(lockstep)) {}
  explicit TaskOf(Scene scene, std::optional<LockstepSettings> lockstep = {})
      : model(build_model(std::move(scene))), state(model), arm(model.scene.step_s) {
    RunSettings settings;
    settings.lockstep = std::move(lockstep);
    settings.watchers = {&arm};
    recording = run_scene(model, state, settings);
    told = summarize(model, recording).at("task");
  }
  [[nodiscard]] Outcome outcome() const { return recording.verdict.outcome; }
  [[nodiscard]] std::string words() const { return in_words(recording.verdict); }
  /// How far the object is from where it began, against the table, object axes at the start.
  [[nodiscard]] Eigen::Vector3d carried_m() const {
    return model.scene.object.X_WO.linear().transpose() *
           (state.X_WO.translation() + arm.arms_m.back() - model.scene.object.X_WO.translation());
  }

  Model model;
  State state;
  ArmWatcher arm;
  Recording recording;
  nlohmann::ordered_json told;
};

}  // namespace thenar::task_test
