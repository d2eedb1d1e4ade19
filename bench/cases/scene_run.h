#pragma once

#include <cmath>
#include <utility>

#include "engine/grasp/contact_tick.h"
#include "engine/grasp/control_tick.h"
#include "engine/grasp/model.h"
#include "engine/results/lockstep.h"
#include "engine/scenes/build_model.h"

namespace thenar {

/// A scene's two ticks in one loop, as run_monolithic has them, without the bookkeeping.
struct Loop {
  explicit Loop(Model m) : model(std::move(m)), state(model), frame(model), controller(model), work(model) {}
  explicit Loop(Scene scene) : Loop(build_model(std::move(scene))) {}

  void control() {
    const State snapshot = state;
    report = control_tick(model, snapshot, controller, frame);
  }
  TickReport tick() {
    if (model.control_is_due(state.tick)) control();
    return contact_tick(model, frame, work, state);
  }
  void run(double duration_s) {
    const auto end = state.tick + std::lround(duration_s / model.scene.step_s);
    while (state.tick < end) tick();
  }

  Model model;
  State state;
  Frame frame;
  Controller controller;
  ContactWorkspace work;
  ControlReport report;
};

/// A run of the scene, tick by tick: in one loop, or in lockstep where its control period is longer than its step.
class SceneRun {
 public:
  explicit SceneRun(Scene scene)
      : loop_(scene), split_(loop_.model), one_loop_(!(scene.control_period_s > scene.step_s)) {}

  [[nodiscard]] const Model& model() const { return loop_.model; }
  [[nodiscard]] const State& state() const { return one_loop_ ? loop_.state : split_.state; }
  [[nodiscard]] const Frame& frame() const { return one_loop_ ? loop_.frame : split_.frame(); }
  [[nodiscard]] const ContactWorkspace& work() { return one_loop_ ? loop_.work : split_.workspace(); }
  [[nodiscard]] double time_s() const { return static_cast<double>(state().tick) * model().scene.step_s; }
  TickReport tick() { return one_loop_ ? loop_.tick() : split_.tick(); }

 private:
  Loop loop_;
  Lockstep split_;
  bool one_loop_;
};

}  // namespace thenar
