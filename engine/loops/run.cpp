// SPDX-License-Identifier: Apache-2.0
#include "engine/loops/run.h"

#include <cmath>
#include <utility>

#include "engine/grasp/stopwatch.h"
#include "engine/loops/surface_display.h"

namespace thenar {
namespace {

// A viewer's frame rate.
constexpr double kPictures_Hz = 60.0;

}  // namespace

GraspRun::GraspRun(const Model& m, const FramePolicy& policy, std::optional<LockstepSettings> settings)
    : Run(m, policy, settings ? settings->seed : 0), model(m), work(m), lockstep_(std::move(settings)) {}

TickReport GraspRun::tick(const TickInput& input) {
  control_if_due();
  return contact(input);
}

void GraspRun::control_if_due() {
  controlled = model.control_is_due(state.tick);
  if (controlled) control();
}

TickReport GraspRun::contact(const TickInput& input) {
  if (lockstep_) receive();
  return contact_tick(model, frame, memory, work, state, input);
}

void GraspRun::control() {
  if (lockstep_) return send();
  report = control_tick(model, state, controller, frame);
}

void GraspRun::send() {
  const double now_s = time_s();
  SentFrame sent(model, now_s);
  report = control_tick(model, state, controller, sent.frame);
  if (sent.frame.sequence > 0) {
    sent.due_s += model.scene.control_delay_s + lockstep_->jitter_s * std::uniform_real_distribution<>()(random);
  }
  if (lockstep_->late_s) sent.due_s += lockstep_->late_s(now_s);
  if (lockstep_->channel && !lockstep_->channel(now_s, sent.frame)) return;
  under_way.push_back(std::move(sent));
}

void GraspRun::receive() {
  const auto is_due = [now_s = time_s()](const SentFrame& sent) { return sent.due_s <= now_s + 1e-9; };
  for (SentFrame& sent : under_way) {
    if (is_due(sent) && sent.frame.sequence > frame.sequence) frame = sent.frame;
  }
  std::erase_if(under_way, is_due);
}

void run_ticks(GraspRun& run, std::int64_t ticks, std::span<Watcher* const> watchers, bool shows) {
  std::vector<SurfaceDisplay> displays;
  for (const Pulp& pulp : run.model.pulps) {
    if (shows && !run.is_lockstep()) displays.emplace_back(pulp);
  }
  const Eigen::VectorXd& muscle_forces_N = run.controller.f_muscle;
  double picture = -1.0;  // the number of the last one
  for (bool goes_on = true; ticks > 0; --ticks) {
    run.control_if_due();
    if (run.controlled) {
      const ControlTick done{run.time_s(), run.report, muscle_forces_N, &run};
      for (Watcher* watcher : watchers) goes_on = watcher->see_control(done) && goes_on;
      if (!goes_on) return;
    }
    const TickReport contact = run.contact();
    double display_s = 0.0;
    if (const auto now = std::floor(run.time_s() * kPictures_Hz); !displays.empty() && now != picture) {
      picture = now;
      Stopwatch stage;
      for (std::size_t k = 0; k < displays.size(); ++k) displays[k].displace(run.state.u_m[k]);
      display_s = stage.lap();
    }
    const Tick done{run.state, contact, run.report, muscle_forces_N, run.controlled, display_s, &run};
    for (Watcher* watcher : watchers) goes_on = watcher->see_tick(done) && goes_on;
    if (!goes_on) return;
  }
}

}  // namespace thenar
