// SPDX-License-Identifier: Apache-2.0
#include "app/window/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <optional>
#include <stop_token>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "app/window/live_grasps.h"
#include "app/window/live_settings.h"
#include "app/window/live_verdict.h"
#include "app/window/reference.h"
#include "app/window/session_film.h"
#include "app/window/telemetry.h"
#include "app/window/wishes.h"
#include "engine/loops/live_contact.h"
#include "engine/loops/pairing.h"
#include "engine/loops/realtime.h"
#include "engine/loops/split_grasp.h"
#include "engine/loops/threads.h"
#include "engine/recordings/shown_surface.h"
#include "engine/results/recorder.h"

namespace thenar::window {

using nlohmann::ordered_json;

namespace {

constexpr double kPictures_Hz = 30.0, kProblems_Hz = 2.0;  // on the wall's clock
constexpr double kEndless_s = 1e9;
constexpr std::chrono::milliseconds kIdle{20};
constexpr double kOldest_s = 10.0;  // Of input: what claims to be older has another clock.
// So long does a run last at least: wishes that pour in must not keep the loops from running.
constexpr std::int64_t kShortestRun_ns = 50'000'000;
// With other fingertips or another grasp pages and a recording get the scene again, 1.1 MB: not more often than this.
constexpr std::int64_t kSceneRest_ns = 1'000'000'000;
}  // namespace

struct Session::Impl {
  Impl(Model m, const SessionSettings& s);

  // The server's thread:
  std::string receive(const Message& message);
  void let_go();
  void send(const std::optional<double>& stamp_s);

  // The calling thread:
  void run(const Display& shown_on, const std::atomic<bool>& stop);
  void heed_wanted();
  void change_scene(const LiveSettings& before);
  void begin_with(const Take& wish);
  void begin_film();
  void reset();
  [[nodiscard]] ControlSample first_control() const;
  void run_loops(const std::atomic<bool>& stop);
  void do_step();
  void wait_idle();
  bool see(const ContactSample& sample, const ControlSample& control);
  void look_aside();
  void show(const Picture& picture, TickRecord tick, const Eigen::VectorXd& muscle_forces_N);
  void show_still();
  void show_scene();
  void show_status(bool running);
  [[nodiscard]] bool is_watched() const { return display->pages() > 0; }
  [[nodiscard]] int delay_periods() const { return static_cast<int>(heeded.settings.number("delay_periods")); }
  /// Between two runs.
  [[nodiscard]] double time_s() const { return static_cast<double>(grasp->state().tick) * model.scene.step_s; }

  const SessionSettings settings;
  const CoreSetAside core;

  // Between the threads.
  LatestValue<LiveInput> inputs;
  Wishes wishes;

  LiveGrasps grasps;

  // The server's thread's.
  LiveInput input;

  // The calling thread's, and in a run the loops'.
  Model model;
  LiveHands hands;
  TriangleMesh surface;  ///< Of the object, which stays.
  std::unique_ptr<SplitGrasp> grasp;
  std::unique_ptr<LiveContact> live;

  // The calling thread's.
  const Display* display = nullptr;
  SessionFilm film;
  Wanted heeded;
  bool can_run = false;  ///< Grasp forces exist at the start.
  Pairing pairing;
  Telemetry telemetry;
  Reference reference;
  LiveVerdict verdict;
  std::size_t shown_warnings = 0;
  std::optional<std::string> note;
  std::string scheduling;
  std::string status;  ///< As it was shown last, and
  Verdict shown;       ///< the verdict in it.
  TickRecord last_tick;
  std::int64_t unaccounted = 0;   ///< The most of any grasp.
  std::int64_t scene_due_ns = 0;  ///< When pages may get another scene,
  bool scene_waits = false;       ///< which is wished for.
  bool still_shown = false;
  std::string bytes;
};

Session::Impl::Impl(Model m, const SessionSettings& s)
    : settings(s),
      core(s.realtime, s.core),
      grasps(m, s.asked),
      model(std::move(m)),
      hands(model),
      surface(shown_surface(model)),
      film(model, s.recording, s.record_folder),
      pairing([this](const ContactSample& sample, const ControlSample& control) { return see(sample, control); }),
      verdict(model) {
  heeded.settings = heeded.begun = live_settings(model);
  heeded.record = !settings.record.empty();
  wishes.correct([this](Wanted& w) { w = heeded; });
  reset();
  if (heeded.record) film.begin(settings.record, surface, 0.0, *live);
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
      wishes.change([](Wanted& w) { w.paused = true; });
    } else if constexpr (std::is_same_v<Kind, Resume>) {
      wishes.change([](Wanted& w) { w.paused = false; });
    } else if constexpr (std::is_same_v<Kind, Step>) {
      wishes.change([&](Wanted& w) {
        if (w.paused) {
          w.steps = std::min(w.steps + 1, 100);
        } else {
          refusal = "step needs a pause";
        }
      });
    } else if constexpr (std::is_same_v<Kind, Reset>) {
      let_go();
      wishes.change([](Wanted& w) { w.reset = true; });
    } else if constexpr (std::is_same_v<Kind, Find>) {
      wishes.change([&](Wanted& w) { refusal = grasps.find(m, w.begun, w.settings); });
    } else if constexpr (std::is_same_v<Kind, StopFinding>) {
      refusal = grasps.stop();
    } else if constexpr (std::is_same_v<Kind, Take>) {
      wishes.change([&](Wanted& w) {
        refusal = grasps.check(m, w.record);
        if (refusal.empty()) w.take = m;
      });
      if (refusal.empty()) let_go();
    } else if constexpr (std::is_same_v<Kind, Record>) {
      wishes.change([&](Wanted& w) { refusal = std::exchange(w.record, true) ? "a recording is being made" : ""; });
    } else if constexpr (std::is_same_v<Kind, StopRecording>) {
      wishes.change([&](Wanted& w) { refusal = std::exchange(w.record, false) ? "" : "no recording is being made"; });
    } else if constexpr (std::is_same_v<Kind, Speed>) {
      wishes.change([&](Wanted& w) { w.speed = m.value; });
    } else if constexpr (std::is_same_v<Kind, Set>) {
      wishes.change([&](Wanted& w) { refusal = change(m, w.settings); });
    } else {
      refusal = "the server answers this";
    }
  };
  std::visit(heed, message);
  return refusal;
}

void Session::Impl::let_go() {
  input.pull.reset();
  input.target_shift_m.setZero();
  input.target_turn_rad.setZero();
  send({});
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
  film.finish(*live);
}

void Session::Impl::heed_wanted() {
  const bool scene_due = steady_now_ns() >= scene_due_ns;
  Wanted now = wishes.heed(scene_due);
  now.steps = now.paused ? std::min(now.steps + heeded.steps, 100) : 0;
  scene_waits = !scene_due && (now.take || !same_fingertips(now.settings, heeded.settings));
  if (!scene_due) {
    copy_fingertips(heeded.settings, now.settings);
    now.take.reset();
  }
  const LiveSettings before = std::exchange(heeded, now).settings;
  if (!now.record) film.end(*live);
  const bool other_scene = !(now.settings == before);
  if (other_scene) change_scene(before);
  if (now.take) {
    begin_with(*now.take);
  } else if (now.reset || (other_scene && !can_run)) {
    reset();  // A start that no forces hold may be held by others.
  }
  // A scene that is about to come may have other fingers.
  if (now.record && !film.is_on() && !scene_waits) begin_film();
}

/// Begins a recording that a page wants.
void Session::Impl::begin_film() {
  film.begin_in_folder(surface, time_s(), *live);
  still_shown = false;  // In a pause it gets the state that is seen.
  if (!film.is_on()) wishes.correct([](Wanted& w) { w.record = false; });
}

/// Begins again, with a grasp that was found, or as the scene itself began.
void Session::Impl::begin_with(const Take& wish) {
  std::optional<Model> next = grasps.take(wish);
  if (!next) return;
  next->object_notes = std::move(model.object_notes);
  model = std::move(*next);
  scene_due_ns = steady_now_ns() + kSceneRest_ns;
  const LiveSettings begun = live_settings(model);
  wishes.correct([&](Wanted& w) {
    w.settings = carried_over(heeded.settings, w.settings, begun);
    w.begun = begun;
    grasps.ask_as_taken();
  });
  heeded.settings = heeded.begun = begun;
  reset();
  show_scene();
  film.add_scene(0.0);
}

void Session::Impl::change_scene(const LiveSettings& before) {
  const LiveSettings& wished = heeded.settings;
  const bool other_fingertips = !same_fingertips(wished, before);
  if (other_fingertips) scene_due_ns = steady_now_ns() + kSceneRest_ns;
  std::optional<Model> old;
  if (other_fingertips || wished.value("contact_Hz") != before.value("contact_Hz")) old = model;
  apply(before, wished, model);
  if (old) {
    const double old_now_s = static_cast<double>(grasp->state().tick) * old->scene.step_s;
    grasp = std::make_unique<SplitGrasp>(model, *old, *grasp);
    live = std::make_unique<LiveContact>(model, inputs, hands);
    film.follow(*live);
    pairing.start(first_control());
    verdict.renew_monitor(time_s() - old_now_s);  // Its memory is as long as the steps are short.
  }
  verdict.renew_warnings();
  grasp->heed_scene();
  grasp->hold_frames_back(delay_periods());
  if (other_fingertips && display != nullptr) show_scene();
  if (other_fingertips) film.add_scene(time_s());
  telemetry.set_reference(kNotMeasured, kNotMeasured);
  still_shown = false;
}

void Session::Impl::reset() {
  inputs.take();
  hands.reset(inputs.current());
  grasp = std::make_unique<SplitGrasp>(model);
  grasp->hold_frames_back(delay_periods());
  live = std::make_unique<LiveContact>(model, inputs, hands);
  film.follow(*live);
  telemetry = Telemetry();
  verdict.reset();
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
    verdict.miss(telemetry.lost());
    // All else stays in a run.
    if (in_words(verdict.verdict()) != in_words(shown) || verdict.warnings().size() != shown_warnings) {
      show_status(true);
    }
    const bool may_end = steady_now_ns() - begin_ns > kShortestRun_ns;
    const bool scene_due = scene_waits && steady_now_ns() >= scene_due_ns;
    return !stop && !(may_end && (scene_due || wishes.is_new()));
  };
  const ThreadsReport report = run_threads(*grasp, threads);
  telemetry.end_run(report);
  pairing.finish();
  unaccounted = std::max(unaccounted, report.frames.unaccounted() + report.frames.torn +
                                          report.snapshots.unaccounted() + report.snapshots.torn);
  telemetry.set_unaccounted(unaccounted);
  film.take();
  still_shown = false;
}

/// One control period, on this thread: contact ticks, then the control tick at their end.
void Session::Impl::do_step() {
  const Scene& scene = model.scene;
  const auto ticks = std::max<std::int64_t>(1, std::llround(scene.control_period_s / scene.step_s));
  live->watched = false;
  std::vector<ContactSample> samples;  // Whoever takes them may throw, which the loop may not.
  samples.reserve(ticks);
  run_contact_loop(
      *grasp, Schedule(steady_now_ns(), scene.step_s, ticks, static_cast<int>(ticks)), 0,
      [&samples](const ContactSample& sample) { return samples.push_back(sample), true; }, std::stop_token(),
      live.get());
  for (const ContactSample& sample : samples) pairing.add(sample);
  ControlSample control;
  control.step = grasp->control_step();
  control.muscle_forces_N = grasp->muscle_forces_N();
  pairing.finish();
  pairing.add(control);
  film.take();
  still_shown = false;
}

void Session::Impl::wait_idle() {
  grasps.show(display->set_grasps);
  if (!still_shown && (film.is_on() || is_watched())) show_still();
  wishes.wait(kIdle);
}

/// A tick, with the control tick of its frame.
bool Session::Impl::see(const ContactSample& sample, const ControlSample& control) {
  TickRecord tick = tick_record(model, sample.after, sample.step.tick, control.step.control);
  record_control(control.step.control, tick);
  verdict.add(tick, sample.after, control);
  last_tick = tick;
  film.see(sample.after.tick, tick, control.muscle_forces_N, telemetry);
  if (!sample.shown) return true;
  // A picture taken since stands for a tick that is yet to come here, and is kept for it: on a busy machine records
  // come so late that there would always be a newer one.
  if (live->pictures.current().snapshot.tick < sample.after.tick) live->pictures.take();
  if (const Picture& picture = live->pictures.current(); picture.snapshot.tick == sample.after.tick) {
    show(picture, tick, control.muscle_forces_N);
  }
  return true;
}

/// What is done aside while the loops run.
void Session::Impl::look_aside() {
  live->watched.store(is_watched(), std::memory_order_relaxed);
  film.take();
  if (film.has_failed()) wishes.change([](Wanted& w) { w.record = false; });
  if (live->problems.take()) reference.offer(model, live->problems.current());
  if (const auto result = reference.take_result()) telemetry.set_reference(result->error, result->residual);
  grasps.show(display->set_grasps);
}

void Session::Impl::show(const Picture& picture, TickRecord tick, const Eigen::VectorXd& muscle_forces_N) {
  const LoopFigures& figures = telemetry.figures(steady_now_ns());
  telemetry.write_stages(tick);
  write_state_message(model, picture, tick, muscle_forces_N, figures, bytes);
  display->show(bytes);
}

/// The state between two runs.
void Session::Impl::show_still() {
  State state = grasp->state();
  // A grasp that has not made a tick knows its contacts' forces, but not yet where they are.
  if (grasp->memory().sequence < 0) state.forces.clear();
  Picture picture(model);
  take_picture(state, grasp->memory(), grasp->scratch(), picture);
  picture.pull = hands.pull();
  if (is_watched()) show(picture, last_tick, pairing.in_use().muscle_forces_N);
  film.add(picture, last_tick, pairing.in_use().muscle_forces_N);
  still_shown = true;
}

void Session::Impl::show_scene() {
  display->set_scene(live_scene(model, surface, heeded.begun).dump(), geometry_message(model, surface));
}

void Session::Impl::show_status(bool running) {
  shown = verdict.verdict();
  const std::vector<std::string> sentences = verdict.warnings();
  shown_warnings = sentences.size();
  const auto or_null = [](const auto& text) { return text ? ordered_json(*text) : ordered_json(nullptr); };
  ordered_json json = {{"type", "status"},
                       {"running", running},
                       {"paused", heeded.paused},
                       {"speed", heeded.speed},
                       {"outcome", to_string(shown.outcome)},
                       {"reason", shown.reason},
                       {"warnings", sentences},
                       {"note", or_null(note)},
                       {"scheduling", scheduling},
                       {"settings", settings_json(heeded.settings)}};
  const ordered_json recorded = json;
  json["recording"] = film.news();
  if (std::string text = json.dump(); std::exchange(status, text) == text) return;
  display->set_status(status);
  film.add_status(last_tick.time_s, recorded);  // The state itself may be the contact thread's now.
}

Session::Session(Model model, const SessionSettings& settings)
    : impl_(std::make_unique<Impl>(std::move(model), settings)) {}
Session::~Session() = default;

std::string Session::receive(const Message& message) { return impl_->receive(message); }

void Session::run(const Display& display, const std::atomic<bool>& stop) { impl_->run(display, stop); }

}  // namespace thenar::window
