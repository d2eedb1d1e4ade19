// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <utility>

#include "engine/grasp/model.h"
#include "engine/loops/run.h"
#include "engine/models/build_model.h"

namespace thenar {

struct OwnModel {
  Model model;
};

/// A run in one loop, and the model that it is of.
struct Loop : OwnModel, GraspRun {
  explicit Loop(Model m) : OwnModel{std::move(m)}, GraspRun(OwnModel::model) {}
  explicit Loop(Scene scene) : Loop(build_model(std::move(scene))) {}
  Loop(const Loop& other) : OwnModel(other), GraspRun(OwnModel::model) {
    go_on_as(other);
    work = other.work;
  }

  void run(double duration_s) {
    const auto end = state.tick + std::lround(duration_s / model.scene.step_s);
    while (state.tick < end) tick();
  }

  using OwnModel::model;
};

/// A run of the model in one loop, or in lockstep where its control period is longer than its step.
[[nodiscard]] inline GraspRun as_threads_would(const Model& model) {
  return model.scene.control_period_s > model.scene.step_s ? GraspRun(model, LockstepSettings{}) : GraspRun(model);
}

}  // namespace thenar
