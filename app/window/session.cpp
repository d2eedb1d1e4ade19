#include "app/window/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <stop_token>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "app/window/live_settings.h"
#include "app/window/reference.h"
#include "app/window/telemetry.h"
#include "engine/loops/live_contact.h"
#include "engine/loops/pairing.h"
#include "engine/loops/realtime.h"
#include "engine/loops/split_grasp.h"
#include "engine/loops/threads.h"
#include "engine/results/grasp_monitor.h"
#include "engine/results/recorder.h"
#include "engine/results/recording_file.h"
#include "engine/results/warnings.h"

namespace thenar::window {

using nlohmann::ordered_json;

namespace {

constexpr double kPictures_Hz = 30.0, kProblems_Hz = 2.0;  // on the wall's clock
constexpr double kEndless_s = 1e9;
constexpr std::chrono::milliseconds kIdle{20};
constexpr double kOldest_s = 10.0;  // Of input: what claims to be older has another clock.
// So long does a run last at least: wishes that pour in must not keep the loops from running.
constexpr std::int64_t kShortestRun_ns = 50'000'000;
// With other fingertips pages and a recording get the scene again, 1.1 MB: not more often than this.
constexpr std::int64_t kFingertipsRest_ns = 1'000'000'000;
// A monitor sums up slip. In a run without end it begins again from time to time, so that years of creep do not count
// as a loss; and soon after something went wrong, to tell when the object is held again.
constexpr double kWatch_s = 10.0, kWatchFailed_s = 3.0;
constexpr double kJudge_s = 0.1;  // Simulated time from one verdict to the next.

}  // namespace

struct Session::Impl {
  Impl(Model m, const SessionSettings& s);

  // The server's thread:
  std::string receive(const Message& message);
  template <typename Change>
  void want(const Change& change);
  void send(const std::optional<double>& stamp_s);

  // The calling thread:
  void run(const Display& shown_on, const std::atomic<bool>& stop);
  void heed_wanted();
  void change_scene(const LiveSettings& before);
  void reset();
  [[nodiscard]] ControlSample first_control() const;
  void run_loops(const std::atomic<bool>& stop);
  void do_step();
  void wait_idle();
  bool see(const ContactSample& sample, const ControlSample& control);
  void watch(TickRecord& tick, const ControlSample& control);
  void look_aside();
  void show(const Picture& picture, TickRecord tick, const Eigen::VectorXd& muscle_forces_N);
  void show_still();
  void show_scene();
  void show_status(bool running);
  [[nodiscard]] bool is_watched() const { return recording || display->pages() > 0; }
  /// Between two runs.
  [[nodiscard]] double time_s() const { return static_cast<double>(grasp->state().tick) * model.scene.step_s; }

  const SessionSettings settings;
  const CoreSetAside core;

  // Between the threads.
  LatestValue<LiveInput> inputs;
  std::mutex mutex;  // of `wanted`
  Wanted wanted;
  std::condition_variable woken;
  std::atomic<bool> changed{false};

  // The server's thread's.
  LiveInput input;

  // The calling thread's, and in a run the loops'.
  Model model;
  LiveHands hands;
  std::unique_ptr<SplitGrasp> grasp;
  std::unique_ptr<LiveContact> live;

  // The calling thread's.
  const Display* display = nullptr;
  std::optional<RecordingFile> recording;
  Wanted heeded;
  bool can_run = false;  ///< Grasp forces exist at the start.
  Pairing pairing;
  Telemetry telemetry;
  Reference reference;
  std::optional<GraspMonitor> monitor;
  double watch_from_s = 0.0, judged_s = 0.0, found_s = 0.0;
  Verdict judged;  ///< What is shown: the last that was not held, until a whole watch has found nothing.
  std::optional<Warnings> warnings;
  std::size_t shown_warnings = 0;
  std::optional<std::string> note;
  std::string scheduling;
  std::string status;  ///< As it was shown last, and
  Verdict shown;       ///< the verdict in it.
  TickRecord last_tick;
  RunSums sums;                        ///< Of all ticks; the monitor begins again.
  std::int64_t unaccounted = 0;        ///< The most of any grasp.
  std::int64_t missed = 0;             ///< Lost records that the monitor knows of.
  std::int64_t fingertips_due_ns = 0;  ///< When they may change again,
  bool fingertips_wait = false;        ///< which is wished for.
  bool still_shown = false;
  std::string bytes;
};

Session::Impl::Impl(Model m, const SessionSettings& s)
    : settings(s),
      core(s.realtime, s.core),
      model(std::move(m)),
      hands(model),
      pairing([this](const ContactSample& sample, const ControlSample& control) { return see(sample, control); }) {
  wanted.settings = heeded.settings = live_settings(model);
  reset();
  if (!settings.record.empty()) recording.emplace(settings.record, model);
}

// ---- The server's thread.

std::string Session::Impl::receive(const Message& message) {
  std::string refusal;
  const auto heed = [&](const auto& m) {
    using Kind = std::decay_t<decltype(m)>;
    if constexpr (std::is_same_v<Kind, Pull>) {
      input.pull = {m.point_m, m.handle_m};
      input.pull_heard_ns = steady_now_ns();
      send(m.stamp_s);
    } else if constexpr (std::is_same_v<Kind, Release>) {
      input.pull.reset();
      send({});
    } else if constexpr (std::is_same_v<Kind, Target>) {
      input.target_shift_m = m.shift_m;
      input.target_turn_rad = m.turn_rad;
      send(m.stamp_s);
    } else if constexpr (std::is_same_v<Kind, Poke>) {
      input.poke_N = m.force_N;
      ++input.pokes;
      send(m.stamp_s);
    } else if constexpr (std::is_same_v<Kind, Pause>) {
      want([](Wanted& w) { w.paused = true; });
    } else if constexpr (std::is_same_v<Kind, Resume>) {
      want([](Wanted& w) { w.paused = false; });
    } else if constexpr (std::is_same_v<Kind, Step>) {
      want([&](Wanted& w) {
        if (w.paused) {
          w.steps = std::min(w.steps + 1, 100);
        } else {
          refusal = "step needs a pause";
        }
      });
    } else if constexpr (std::is_same_v<Kind, Reset>) {
      input.pull.reset();
      input.target_shift_m.setZero();
      input.target_turn_rad.setZero();
      send({});
      want([](Wanted& w) { w.reset = true; });
    } else if constexpr (std::is_same_v<Kind, Speed>) {
      want([&](Wanted& w) { w.speed = m.value; });
    } else if constexpr (std::is_same_v<Kind, Set>) {
      want([&](Wanted& w) { refusal = change(m, w.settings); });
    } else {
      refusal = "the server answers this";
    }
  };
  std::visit(heed, message);
  return refusal;
}

template <typename Change>
void Session::Impl::want(const Change& change) {
  const std::lock_guard lock(mutex);
  const Wanted before = wanted;
  change(wanted);
  if (wanted == before) return;  // refused, or nothing new: the loops go on
  // Relaxed: the mutex orders what is wanted; this only says when to look.
  changed.store(true, std::memory_order_relaxed);
  woken.notify_one();
}

void Session::Impl::send(const std::optional<double>& stamp_s) {
  ++input.number;
  const std::int64_t now_ns = steady_now_ns();
  const double now_s = 1e-9 * static_cast<double>(now_ns);
  const bool known = stamp_s && *stamp_s > now_s - kOldest_s && *stamp_s < now_s;
  input.stamp_ns = known ? std::llround(1e9 * *stamp_s) : now_ns;
  inputs.draft() = input;
  inputs.publish();
}

// ---- The calling thread.

void Session::Impl::run(const Display& shown_on, const std::atomic<bool>& stop) {
  display = &shown_on;
  show_scene();
  while (!stop) {
    heed_wanted();
    if (heeded.paused && can_run && heeded.steps > 0) {
      --heeded.steps;
      do_step();
    } else if (heeded.paused || !can_run) {
      show_status(false);
      wait_idle();
    } else {
      run_loops(stop);
    }
  }
  if (recording) recording->finish();
}

void Session::Impl::heed_wanted() {
  changed.store(false, std::memory_order_relaxed);
  Wanted now;
  {
    const std::lock_guard lock(mutex);
    now = wanted;
    wanted.steps = 0;
    wanted.reset = false;
  }
  now.steps = now.paused ? std::min(now.steps + heeded.steps, 100) : 0;
  fingertips_wait = !same_fingertips(now.settings, heeded.settings) && steady_now_ns() < fingertips_due_ns;
  if (fingertips_wait) {
    now.settings.kernel = heeded.settings.kernel;
    now.settings.level = heeded.settings.level;
  }
  const LiveSettings before = std::exchange(heeded, now).settings;
  const bool other_scene = !(now.settings == before);
  if (other_scene) change_scene(before);
  // A start that no forces hold may be held by others.
  if (now.reset || (other_scene && !can_run)) reset();
}

void Session::Impl::change_scene(const LiveSettings& before) {
  const LiveSettings& wished = heeded.settings;
  const bool other_fingertips = !same_fingertips(wished, before);
  if (other_fingertips) fingertips_due_ns = steady_now_ns() + kFingertipsRest_ns;
  std::optional<Model> old;
  if (other_fingertips || wished.contact_Hz != before.contact_Hz) old = model;
  apply(before, wished, model);
  if (old) {
    const double old_now_s = static_cast<double>(grasp->state().tick) * old->scene.step_s;
    grasp = std::make_unique<SplitGrasp>(model, *old, *grasp);
    live = std::make_unique<LiveContact>(model, inputs, hands);
    pairing.start(first_control());
    for (double* const since_s : {&watch_from_s, &judged_s, &found_s}) *since_s += time_s() - old_now_s;
    monitor.emplace(model);  // Its memory is as long as the steps are short.
  }
  warnings.emplace(model);
  grasp->heed_scene();
  grasp->hold_frames_back(wished.delay_periods);
  if (other_fingertips && display != nullptr) show_scene();
  if (other_fingertips && recording) recording->add_scene(model, time_s());
  telemetry.set_reference(kUnknown, kUnknown);
  still_shown = false;
}

void Session::Impl::reset() {
  inputs.take();
  hands.reset(inputs.current());
  grasp = std::make_unique<SplitGrasp>(model);
  grasp->hold_frames_back(heeded.settings.delay_periods);
  live = std::make_unique<LiveContact>(model, inputs, hands);
  telemetry = Telemetry();
  missed = 0;
  monitor.emplace(model);
  watch_from_s = judged_s = found_s = 0.0;
  sums = {};
  judged = {};
  warnings.emplace(model);
  note.reset();
  can_run = grasp->first_control().grasp == GraspStatus::kOptimal;
  if (!can_run) note = "no grasp forces hold the object at the start: change the scene, or reset";
  pairing = Pairing([this](const ContactSample& sample, const ControlSample& control) { return see(sample, control); });
  pairing.start(first_control());
  last_tick = tick_record(model, grasp->state(), TickReport(model.scene.hand), grasp->first_control());
  still_shown = false;
}

/// The control tick of a new grasp's first frame.
ControlSample Session::Impl::first_control() const {
  ControlSample first;
  first.step.control = grasp->first_control();
  first.step.sequence = grasp->controller().sequence - 1;
  first.step.published = true;
  first.muscle_forces_N = grasp->muscle_forces_N();
  return first;
}

void Session::Impl::run_loops(const std::atomic<bool>& stop) {
  const Scene& scene = model.scene;
  const double steps_per_s = heeded.speed / scene.step_s;
  const auto every = [&](double rate_Hz) { return std::max<std::int64_t>(1, std::llround(steps_per_s / rate_Hz)); };
  live->picture_ticks = every(kPictures_Hz);
  live->problem_ticks = every(kProblems_Hz);
  live->watched = is_watched();
  // What came while nothing ran is no latency.
  inputs.take();
  live->number = inputs.current().number;
  telemetry.begin_run(scene.step_s);

  const std::int64_t begin_ns = steady_now_ns();
  ThreadSettings threads;
  threads.duration_s = kEndless_s;
  threads.speed = heeded.speed;
  threads.spin_s = settings.spin_s;
  threads.realtime = settings.realtime;
  threads.set_aside = &core;
  threads.quiet = settings.quiet;
  threads.live = live.get();
  threads.on_start = [&](const Scheduling& contact) {
    scheduling = in_words(contact);
    show_status(true);
  };
  threads.on_tick = [&](const ContactSample& sample) {
    telemetry.add(sample);
    pairing.add(sample);
    return true;
  };
  threads.on_control = [&](const ControlSample& sample) {
    telemetry.add(sample);
    pairing.add(sample);
  };
  threads.on_look = [&] {
    look_aside();
    if (const std::int64_t lost = telemetry.lost(); lost > missed) {
      monitor->miss(fmt::format("the records of {} ticks were lost: nobody saw what they did", lost - missed));
      missed = lost;
    }
    // All else stays in a run.
    if (in_words(judged) != in_words(shown) || warnings->sentences().size() != shown_warnings) show_status(true);
    const bool may_end = steady_now_ns() - begin_ns > kShortestRun_ns;
    const bool fingertips_due = fingertips_wait && steady_now_ns() >= fingertips_due_ns;
    return !stop && !(may_end && (fingertips_due || changed.load(std::memory_order_relaxed)));
  };
  const ThreadsReport report = run_threads(*grasp, threads);
  telemetry.end_run(report);
  pairing.finish();
  unaccounted = std::max(unaccounted, report.frames.unaccounted() + report.frames.torn +
                                          report.snapshots.unaccounted() + report.snapshots.torn);
  telemetry.set_unaccounted(unaccounted);
  still_shown = false;
}

/// One control period, on this thread: contact ticks, then the control tick at their end.
void Session::Impl::do_step() {
  const Scene& scene = model.scene;
  const auto ticks = std::max<std::int64_t>(1, std::llround(scene.control_period_s / scene.step_s));
  const auto all_late = static_cast<int>(ticks);
  const std::stop_token never;
  live->watched = false;
  std::vector<ContactSample> samples;  // Whoever takes them may throw, which the loop may not.
  samples.reserve(ticks);
  run_contact_loop(
      *grasp, Schedule(steady_now_ns(), scene.step_s, ticks, all_late), 0,
      [&samples](const ContactSample& sample) {
        samples.push_back(sample);
        return true;
      },
      never, live.get());
  for (const ContactSample& sample : samples) pairing.add(sample);
  ControlSample control;
  control.step = grasp->control_step();
  control.muscle_forces_N = grasp->muscle_forces_N();
  pairing.finish();
  pairing.add(control);
  still_shown = false;
}

void Session::Impl::wait_idle() {
  if (!still_shown && is_watched()) show_still();
  std::unique_lock lock(mutex);
  woken.wait_for(lock, kIdle, [this] { return changed.load(std::memory_order_relaxed); });
}

/// A tick, with the control tick of its frame.
bool Session::Impl::see(const ContactSample& sample, const ControlSample& control) {
  TickRecord tick = tick_record(model, sample.after, sample.step.tick, control.step.control);
  record_control(control.step.control, tick);
  watch(tick, control);
  last_tick = tick;
  if (!sample.shown) return true;
  live->pictures.take();
  const Picture& picture = live->pictures.current();
  // A picture taken since stands for a tick that is yet to come here.
  if (picture.snapshot.tick == sample.after.tick) show(picture, tick, control.muscle_forces_N);
  return true;
}

/// Judges the grasp, and sums up what the ticks report.
void Session::Impl::watch(TickRecord& tick, const ControlSample& control) {
  sums.add(tick);
  if (tick.contact.handed_over) {
    monitor->add(tick.time_s - model.scene.step_s, control.step.control, control.muscle_forces_N);
  }
  warnings->add(tick);
  monitor->add(tick);
  const bool watched = tick.time_s - watch_from_s > (judged.outcome == Outcome::kHeld ? kWatch_s : kWatchFailed_s);
  if (!watched && !monitor->lost() && tick.time_s - judged_s < kJudge_s) return;
  judged_s = tick.time_s;
  Verdict verdict = monitor->verdict();
  const bool failed = verdict.outcome != Outcome::kHeld;
  // Of one trouble the gravest word stays.
  const bool graver = verdict.outcome >= judged.outcome || tick.time_s - found_s > kWatchFailed_s;
  if (failed ? graver : watched) {
    judged = std::move(verdict);
    found_s = tick.time_s;
  }
  if (!failed && !watched) return;
  monitor.emplace(model);
  watch_from_s = tick.time_s;
}

/// What is done aside while the loops run.
void Session::Impl::look_aside() {
  live->watched.store(is_watched(), std::memory_order_relaxed);
  if (live->problems.take()) reference.offer(model, live->problems.current());
  if (const auto result = reference.take_result()) telemetry.set_reference(result->error, result->residual);
}

void Session::Impl::show(const Picture& picture, TickRecord tick, const Eigen::VectorXd& muscle_forces_N) {
  const LoopFigures& figures = telemetry.figures(steady_now_ns());
  telemetry.write_stages(tick);
  write_state_message(model, picture, tick, muscle_forces_N, figures, bytes);
  display->show(bytes);
  if (recording) recording->add(tick.time_s, bytes);
}

/// The state between two runs.
void Session::Impl::show_still() {
  State state = grasp->state();
  // A grasp that has not made a tick knows its contacts' forces, but not yet where they are.
  if (grasp->workspace().sequence < 0) state.forces.clear();
  Picture picture(model);
  take_picture(state, grasp->workspace(), picture);
  picture.pull = hands.pull();
  show(picture, last_tick, pairing.in_use().muscle_forces_N);
  still_shown = true;
}

void Session::Impl::show_scene() { display->set_scene(scene_message(model, true).dump(), geometry_message(model)); }

void Session::Impl::show_status(bool running) {
  shown = judged;
  const std::vector<std::string> sentences = warnings->sentences();
  shown_warnings = sentences.size();
  const auto or_null = [](const auto& text) { return text ? ordered_json(*text) : ordered_json(nullptr); };
  const ordered_json json = {{"type", "status"},
                             {"running", running},
                             {"paused", heeded.paused},
                             {"speed", heeded.speed},
                             {"outcome", to_string(judged.outcome)},
                             {"reason", judged.reason},
                             {"warnings", sentences},
                             {"note", or_null(note)},
                             {"scheduling", scheduling},
                             {"settings", settings_json(heeded.settings)}};
  const std::string text = json.dump();
  if (text == status) return;
  status = text;
  display->set_status(status);
  if (recording) recording->add_status(last_tick.time_s, json);  // The state itself may be the contact thread's now.
}

Session::Session(Model model, const SessionSettings& settings)
    : impl_(std::make_unique<Impl>(std::move(model), settings)) {}
Session::~Session() = default;

std::string Session::receive(const Message& message) { return impl_->receive(message); }

void Session::run(const Display& display, const std::atomic<bool>& stop) { impl_->run(display, stop); }

}  // namespace thenar::window
