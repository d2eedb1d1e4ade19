#include "engine/results/realtime_run.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "engine/loops/live_contact.h"
#include "engine/results/pairing.h"
#include "engine/results/recorder.h"

namespace thenar {

RealtimeRun run_realtime(const Model& model, State& state, ThreadSettings settings, LoopProfile& profile,
                         const Progress& progress, RecordingFile* film) {
  Recorder recorder(model);
  bool lost = false;
  std::optional<double> interrupted_s;
  LatestValue<LiveInput> nobody;
  LiveHands hands(model);
  std::optional<LiveContact> live;
  if (film != nullptr) {
    live.emplace(model, nobody, hands);
    live->picture_ticks = std::max(1L, std::lround(1.0 / (kRecordingRate_Hz * model.scene.step_s)));
    live->problem_ticks = std::numeric_limits<std::int64_t>::max();
    live->watched = true;
    settings.live = &*live;
  }
  const auto record = [&](const ContactSample& sample, const ControlSample& control) {
    TickRecord tick = tick_record(model, sample.after, sample.step.tick, control.step.control);
    if (tick.contact.handed_over) record_control(control.step.control, tick);
    lost = !recorder.add(tick, control.muscle_forces_N);
    if (sample.shown) live->pictures.take();
    // A picture taken since stands for a tick that is yet to come here.
    if (sample.shown && live->pictures.current().snapshot.tick == sample.after.tick) {
      film->add(live->pictures.current(), tick, control.muscle_forces_N);
    }
    return !lost;
  };
  Pairing pairing(record, [&](const ContactSample& sample, const ControlSample& control) {
    const double start_s = static_cast<double>(sample.after.tick - 1) * model.scene.step_s;
    recorder.add(start_s, control.step.control, control.muscle_forces_N);
  });
  std::int64_t first_ns = 0;
  settings.on_first_control = [&](const ControlReport& control, const Eigen::VectorXd& muscle_forces_N) {
    profile.begin(control, muscle_forces_N);
    recorder.add(0.0, control, muscle_forces_N);
    ControlSample first;
    first.step.control = control;
    first.muscle_forces_N = muscle_forces_N;
    pairing.start(first);
  };
  settings.on_tick = [&](const ContactSample& sample) {
    profile.add(sample);
    pairing.add(sample);
    if (first_ns == 0) first_ns = sample.deadline_ns;
    const double simulated_s = static_cast<double>(sample.after.tick) * model.scene.step_s;
    const double wall_s = 1e-9 * static_cast<double>(sample.end_ns - first_ns);
    if (progress && !interrupted_s && !progress(simulated_s, wall_s)) interrupted_s = simulated_s;
    return !lost && !interrupted_s;
  };
  settings.on_control = [&](const ControlSample& sample) {
    profile.add(sample);
    pairing.add(sample);
  };
  RealtimeRun run;
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
