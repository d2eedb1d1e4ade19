#include "engine/results/lockstep.h"

#include <algorithm>
#include <utility>

#include "engine/grasp/stopwatch.h"
#include "engine/results/recorder.h"

namespace thenar {

Lockstep::Lockstep(const Model& model, LockstepSettings settings)
    : state(model),
      model_(model),
      settings_(std::move(settings)),
      random_(settings_.seed),
      controller_(model),
      frame_(model),
      work_(model, split_policy(model.scene)) {}

TickReport Lockstep::tick(const TickInput& input) {
  const double now_s = static_cast<double>(state.tick) * model_.scene.step_s;
  controlled_ = model_.control_is_due(state.tick);
  if (controlled_) run_control(now_s);
  receive(now_s);
  return contact_tick(model_, frame_, work_, state, input);
}

void Lockstep::run_control(double now_s) {
  Sent sent{now_s, Frame(model_)};
  control_ = control_tick(model_, state, controller_, sent.frame);
  if (sent.frame.sequence > 0) {
    sent.due_s += model_.scene.control_delay_s + settings_.jitter_s * std::uniform_real_distribution<>()(random_);
  }
  if (settings_.late_s) sent.due_s += settings_.late_s(now_s);
  if (settings_.channel && !settings_.channel(now_s, sent.frame)) return;
  under_way_.push_back(std::move(sent));
}

void Lockstep::receive(double now_s) {
  const auto is_due = [&](const Sent& sent) { return sent.due_s <= now_s + 1e-9; };
  for (Sent& sent : under_way_) {
    if (is_due(sent) && sent.frame.sequence > frame_.sequence) frame_ = sent.frame;
  }
  std::erase_if(under_way_, is_due);
}

Recording run_lockstep(const Model& model, State& state, const LockstepSettings& settings, const Progress& progress,
                       ProblemDump* dump, RecordingFile* film) {
  Lockstep loops(model, settings);
  loops.state = start_of_run(state);
  Recorder recorder(model);
  Stopwatch wall;
  double wall_s = 0.0;
  for (std::int64_t tick = 0, held = true; tick < recorder.planned() && held; ++tick) {
    const Eigen::Vector3d centre_m = loops.state.X_WO.translation();
    const TickReport contact = loops.tick();
    if (dump != nullptr) {
      if (loops.controlled()) dump->add_control(model, loops.controller(), loops.control(), centre_m);
      dump->add_contact(tick, model, loops.frame(), loops.workspace());
    }
    TickRecord record = tick_record(model, loops.state, contact, loops.control());
    if (loops.controlled()) {
      record_control(loops.control(), record);
      recorder.add(static_cast<double>(tick) * model.scene.step_s, loops.control(), loops.controller().f_muscle);
      if (tick == 0 && recorder.has_unsolved()) break;
    }
    held = recorder.add(record, loops.controller().f_muscle);
    if (film != nullptr) film->add(loops.state, loops.workspace(), record, loops.controller().f_muscle);
    wall_s += wall.lap();
    if (progress && !progress(record.time_s, wall_s)) {
      recorder.interrupt(record.time_s);
      break;
    }
  }
  state = loops.state;
  return recorder.finish(state, loops.control(), wall_s);
}

}  // namespace thenar
