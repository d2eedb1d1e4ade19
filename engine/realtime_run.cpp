#include "engine/realtime_run.h"

#include <deque>
#include <utility>

#include "engine/recorder.h"

namespace thenar {

namespace {

/// Brings together each contact tick and the control tick that made its frame. Their records come on two ways: a contact
/// tick waits here until that of its frame, or a later one, has come.
class Pairing {
 public:
  Pairing(const Model& model, Recorder& recorder) : model_(model), recorder_(recorder) {}

  /// Of frame 0: comes first.
  void start(const ControlReport& control, const Eigen::VectorXd& muscle_forces_N) {
    in_use_.step.control = control;
    in_use_.muscle_forces_N = muscle_forces_N;
  }
  void add(const ContactSample& sample) {
    contact_.push_back(sample);
    record(false);
  }
  void add(const ControlSample& sample) {
    if (sample.step.published) control_.push_back(sample);
    record(false);
  }
  /// Records the ticks that wait, and whose control ticks did not come.
  void finish() { record(true); }

  [[nodiscard]] bool lost() const { return lost_; }
  /// Of the last frame used.
  [[nodiscard]] const ControlReport& control() const { return in_use_.step.control; }

 private:
  void record(bool all) {
    while (!contact_.empty() && !lost_) {
      const std::int64_t sequence = contact_.front().step.tick.sequence;
      const bool known =
          sequence <= in_use_.step.sequence || (!control_.empty() && control_.back().step.sequence >= sequence);
      if (!known && !all) return;
      record(contact_.front());
      contact_.pop_front();
    }
  }

  void record(const ContactSample& sample) {
    const TickReport& tick = sample.step.tick;
    const double start_s = static_cast<double>(sample.after.tick - 1) * model_.scene.step_s;
    while (!control_.empty() && control_.front().step.sequence <= tick.sequence) {
      in_use_ = std::move(control_.front());
      control_.pop_front();
      recorder_.check_grasp(start_s, in_use_.step.control, sample.after.X_WO.translation());
    }
    TickRecord record = tick_record(model_, sample.after, tick, in_use_.step.control);
    if (tick.handed_over) record_control(in_use_.step.control, record);
    lost_ = !recorder_.add(record, in_use_.muscle_forces_N);
  }

  const Model& model_;
  Recorder& recorder_;
  std::deque<ContactSample> contact_;
  std::deque<ControlSample> control_;  // of frames that no recorded tick has used yet
  ControlSample in_use_;               // its frame is that of the last tick recorded
  bool lost_ = false;
};

}  // namespace

RealtimeRun run_realtime(const Model& model, State& state, ThreadSettings settings, LoopProfile& profile,
                         const Progress& progress) {
  Recorder recorder(model);
  Pairing pairing(model, recorder);
  std::int64_t first_ns = 0;
  settings.on_first_control = [&](const ControlReport& control, const Eigen::VectorXd& muscle_forces_N) {
    recorder.check_grasp(0.0, control, state.X_WO.translation());
    pairing.start(control, muscle_forces_N);
  };
  settings.on_tick = [&](const ContactSample& sample) {
    profile.add(sample);
    pairing.add(sample);
    if (first_ns == 0) first_ns = sample.deadline_ns;
    const double simulated_s = static_cast<double>(sample.after.tick) * model.scene.step_s;
    if (progress) progress(simulated_s, 1e-9 * static_cast<double>(sample.end_ns - first_ns));
    return !pairing.lost();
  };
  settings.on_control = [&](const ControlSample& sample) {
    profile.add(sample);
    pairing.add(sample);
  };
  RealtimeRun run;
  run.report = run_threads(model, state, settings);
  pairing.finish();
  run.recording = recorder.finish(state, pairing.control(), run.report.wall_s);
  // Ticks that slipped do not make it one that stopped.
  run.recording.stopped = pairing.lost() || run.report.first_control.grasp != GraspStatus::kOptimal;
  return run;
}

}  // namespace thenar
