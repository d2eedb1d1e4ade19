// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/models/build_model.h"
#include "engine/results/profile.h"
#include "engine/results/recorder.h"
#include "tests/support/scenes.h"

/// A run of two loops whose every number is known.
namespace thenar::known_run {

inline constexpr std::int64_t kStep_ns = 1'000'000;
inline constexpr int kPeriod = 5;  // Steps a control period.

/// A run of two loops whose every number is known. Contact ticks start 10 us late and take 20 us, every 100th 30 us
/// late and 50 us. A frame is new in every 5th tick, where the thumb's force steps by 0.4 N, against 0.1 N elsewhere.
struct SyntheticRun {
  explicit SyntheticRun(int ticks)
      : model(build_model(scene_of("minimal", {"time.control_period=5 ms", "time.duration=1 s"}))), state(model) {
    Recorder recorder(model);
    const ControlReport control(model.scene.hand);
    double force_N = 1.0;
    for (int i = 0; i < ticks; ++i) {
      if (i % kPeriod == 0) run.profile.add(control_sample(i));
      force_N += (i % 2 == 0 ? 1.0 : -1.0) * (i % kPeriod == 0 ? 0.4 : 0.1);
      const ContactSample sample = contact_sample(i, force_N);
      run.profile.add(sample);
      recorder.see_tick(Tick{sample.after, sample.step.tick, control, no_muscles});
    }
    run.recording = recorder.finish(state, control, 1.0);
    ThreadsReport& report = run.report;
    report.ticks = ticks;
    report.overruns = 4;
    report.slipped = 3;
    report.frames = {.published = 11, .consumed = 7, .superseded = 3, .in_flight = 1};
    report.snapshots = {.published = 11, .consumed = 7, .superseded = 2, .in_flight = 1};
    report.contact.policy = "SCHED_FIFO";
    report.contact.core = 1;
  }

  ContactSample contact_sample(int i, double force_N) {
    const bool hundredth = i % 100 == 99;
    ContactSample sample;
    sample.deadline_ns = i * kStep_ns;
    sample.start_ns = sample.deadline_ns + (hundredth ? 30'000 : 10'000);
    sample.end_ns = sample.start_ns + (hundredth ? 50'000 : 20'000);
    sample.after = state;
    sample.after.tick = i + 1;
    for (FingerLoad& load : sample.after.load) {
      load.normal_N = 1.0;
      load.normal = load.force_N = Eigen::Vector3d::UnitZ();
    }
    sample.after.load[0].force_N.x() = force_N;
    TickReport& tick = sample.step.tick;
    tick.sequence = i / kPeriod;
    tick.frame_age = i % kPeriod + 1;
    tick.handed_over = i % kPeriod == 0;
    tick.held = i >= 600 && i < 610;
    tick.contacts = 3;
    tick.solve.sweeps = 4;
    tick.solve.residual = i == 42 ? 0.5 : 1e-4;
    tick.ledger.injected_J = 1e-6;
    tick.ledger.dissipated_J = 4e-6;
    sample.step.publish_ns = 50;
    sample.step.acquire_ns = tick.handed_over ? 300 : 7;  // Only the ticks that took one count.
    return sample;
  }

  static ControlSample control_sample(int i) {
    ControlSample sample;
    sample.deadline_ns = i * kStep_ns - 400'000;
    sample.start_ns = sample.deadline_ns + 1'000;
    sample.end_ns = sample.start_ns + 200'000;
    sample.step.sequence = i / kPeriod;
    sample.step.snapshot_tick = i;
    sample.step.published = true;
    sample.step.control.find_s = 100e-6;
    sample.step.control.factors_s = 50e-6;
    sample.step.control.grasp_s = 5e-6;
    sample.slipped = i == 0 ? 2 : 0;
    return sample;
  }

  Model model;
  State state;
  Eigen::VectorXd no_muscles;
  RealtimeRun run;
};

}  // namespace thenar::known_run
