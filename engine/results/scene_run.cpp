// SPDX-License-Identifier: Apache-2.0
#include "engine/results/scene_run.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/grasp/stopwatch.h"
#include "engine/loops/live_contact.h"
#include "engine/loops/pairing.h"
#include "engine/results/recorder.h"

namespace thenar {

namespace {

/// Tells how far the run is, and ends it where somebody wants that.
class ProgressWatcher : public Watcher {
 public:
  ProgressWatcher(const Model& model, const Progress& progress) : step_s_(model.scene.step_s), progress_(progress) {}

  bool see_tick(const Tick& tick) override {
    wall_s_ += wall_.lap();
    const double time_s = static_cast<double>(tick.after.tick) * step_s_;
    if (!progress_ || progress_(time_s, wall_s_)) return true;
    interrupted_s_ = time_s;
    return false;
  }

  [[nodiscard]] double wall_s() const { return wall_s_; }
  [[nodiscard]] std::optional<double> interrupted_s() const { return interrupted_s_; }

 private:
  double step_s_;
  const Progress& progress_;
  Stopwatch wall_;
  double wall_s_ = 0.0;
  std::optional<double> interrupted_s_;
};

}  // namespace

Recording run_scene(const Model& model, State& state, const RunSettings& settings) {
  GraspRun run = settings.lockstep ? GraspRun(model, *settings.lockstep) : GraspRun(model);
  run.controller.own = settings.own;
  run.state = start_of_run(std::move(state));
  Recorder recorder(model);
  ProgressWatcher progress(model, settings.progress);
  std::vector<Watcher*> watchers = settings.watchers;
  watchers.insert(watchers.end(), {&recorder, &progress});
  run_ticks(run, recorder.planned(), watchers, settings.shows);
  if (const auto time_s = progress.interrupted_s()) recorder.interrupt(*time_s);
  state = std::move(run.state);
  return recorder.finish(state, run.report, progress.wall_s());
}

RealtimeRun run_realtime(const Model& model, State& state, ThreadSettings settings, const Progress& progress,
                         const std::vector<Watcher*>& watchers) {
  RealtimeRun run;
  Recorder recorder(model);
  FilmTap* const tap = settings.live != nullptr ? settings.live->tap : nullptr;
  bool lost = false;
  std::optional<double> interrupted_s;
  const auto see = [&](const ContactSample& sample, const ControlSample& control) {
    const TickReport& contact = sample.step.tick;
    Tick tick{sample.after, contact, control.step.control, control.muscle_forces_N, contact.handed_over};
    if (tap != nullptr) tick.picture = tap->picture_of(sample.after.tick);
    lost = !recorder.see_tick(tick);
    for (Watcher* watcher : watchers) lost = !watcher->see_tick(tick) || lost;
    if (tick.picture != nullptr) tap->pictures.pop();
    return !lost;
  };
  Pairing pairing(see, [&](const ContactSample& sample, const ControlSample& control) {
    const double start_s = static_cast<double>(sample.after.tick - 1) * model.scene.step_s;
    recorder.see_control(ControlTick{start_s, control.step.control, control.muscle_forces_N});
  });
  std::int64_t first_ns = 0;
  settings.on_first_control = [&](const ControlReport& control, const Eigen::VectorXd& muscle_forces_N) {
    recorder.see_control(ControlTick{0.0, control, muscle_forces_N});
    ControlSample first;
    first.step.control = control;
    first.muscle_forces_N = muscle_forces_N;
    pairing.start(first);
  };
  settings.on_tick = [&](const ContactSample& sample) {
    run.profile.add(sample);
    pairing.add(sample);
    if (first_ns == 0) first_ns = sample.deadline_ns;
    const double simulated_s = static_cast<double>(sample.after.tick) * model.scene.step_s;
    const double wall_s = 1e-9 * static_cast<double>(sample.end_ns - first_ns);
    if (progress && !interrupted_s && !progress(simulated_s, wall_s)) interrupted_s = simulated_s;
    return !lost && !interrupted_s;
  };
  settings.on_control = [&](const ControlSample& sample) {
    run.profile.add(sample);
    pairing.add(sample);
  };
  run.report = run_threads(model, state, settings);
  pairing.finish();
  if (const auto what = lost_records(run.report)) recorder.miss(*what);
  if (interrupted_s) recorder.interrupt(*interrupted_s);
  run.recording = recorder.finish(state, pairing.in_use().step.control, run.report.wall_s);
  // Ticks that slipped do not make it one that stopped.
  run.recording.stopped = lost || interrupted_s || run.report.first_control.grasp != GraspStatus::kOptimal;
  return run;
}

}  // namespace thenar
