// SPDX-License-Identifier: Apache-2.0
#include "python/realtime.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "engine/loops/latest_value.h"
#include "engine/loops/live_contact.h"
#include "engine/loops/live_input.h"
#include "engine/loops/realtime.h"
#include "engine/results/profile.h"
#include "engine/results/recorder.h"
#include "engine/results/scene_run.h"
#include "engine/results/summary.h"
#include "python/arrays.h"
#include "python/interpreter.h"
#include "python/laws.h"
#include "python/scene.h"
#include "python/simulation.h"
#include "python/tick_views.h"

namespace thenar::python {

namespace {

/// What of the newest tick is there to be read.
struct Newest {
  Snapshot after;
  TickRecord record;
  Eigen::VectorXd muscle_forces_N;
};

/// Keeps the newest tick for whoever asks, on the thread that receives the loops' records.
class NewestTick : public Watcher {
 public:
  explicit NewestTick(const Model& model) : model_(model) {
    newest_.after = State(model);
    newest_.record = tick_record(model, newest_.after, TickReport(model.scene.hand), ControlReport(model.scene.hand));
    newest_.muscle_forces_N.setZero(model.scene.has_muscles() ? std::ssize(model.scene.hand.muscles) : 0);
  }

  bool see_tick(const Tick& tick) override {
    TickRecord record = tick_record(model_, tick.after, tick.contact, tick.control);
    record_control(tick.control, record);
    sums_.add(record);
    const std::lock_guard lock(mutex_);
    newest_ = {tick.after, record, tick.muscle_forces_N};
    return true;
  }
  [[nodiscard]] Newest get() {
    const std::lock_guard lock(mutex_);
    return newest_;
  }

 private:
  const Model& model_;
  RunSums sums_;
  std::mutex mutex_;
  Newest newest_;
};

/// The two loops of a scene, run by threads of their own. What comes in and goes out passes through buffers: the
/// contact loop never waits for Python. Its thread shares it with Python, which may let go of it anywhere: even in a
/// law of its own, where the garbage collector happens to find it.
class Realtime : public std::enable_shared_from_this<Realtime> {
 public:
  Realtime(std::shared_ptr<const SceneHandle> scene, bool realtime, int core, OwnControl own);

  void start();
  void ask_to_stop() { stopping_.store(true, std::memory_order_relaxed); }
  [[nodiscard]] bool is_stopping() const { return stopping_.load(std::memory_order_relaxed) || is_ending(); }
  /// Waits for its end, so long at most. Whether it has come. Of a run of the process that forked this one: true.
  [[nodiscard]] bool wait(double seconds);
  /// Of a run that has ended. Throws what a law threw.
  [[nodiscard]] const RealtimeRun& result();
  [[nodiscard]] bool running();
  [[nodiscard]] bool started() {
    const std::lock_guard lock(mutex_);
    return started_;
  }
  void send(const std::function<void(LiveInput&)>& change);

  std::shared_ptr<const SceneHandle> scene;
  std::shared_ptr<const Model> model;
  NewestTick newest;

 private:
  void run();

  ThreadSettings settings_;
  LatestValue<LiveInput> inputs_;
  LiveHands hands_;
  LiveContact live_;
  std::mutex input_mutex_;
  LiveInput input_;
  std::atomic<bool> stopping_{false};
  std::mutex mutex_;
  std::condition_variable ended_;
  bool started_ = false, has_ended_ = false;
  pid_t process_ = 0;  ///< Of its thread.
  std::optional<RealtimeRun> result_;
  std::exception_ptr failure_;                ///< Of ours, or
  std::shared_ptr<const py::object> raised_;  ///< an exception of Python, which may be raised again and again.
};

/// The run in whose law this thread is.
thread_local Realtime* run_of_law = nullptr;

/// The law, which says whose it is while it is under way.
template <typename Law>
void mark(Law& law, Realtime* run) {
  if (!law) return;
  law = [law = std::move(law), run](ControlPeriod& period) {
    struct Mark {
      explicit Mark(Realtime* of) : before(std::exchange(run_of_law, of)) {}
      ~Mark() { run_of_law = before; }
      Realtime* before;
    } const inside(run);
    return law(period);
  };
}

Realtime::Realtime(std::shared_ptr<const SceneHandle> of_scene, bool realtime, int core, OwnControl own)
    : scene(std::move(of_scene)),
      model(scene->model()),
      newest(*model),
      hands_(*model),
      live_(*model, inputs_, hands_) {
  settings_.duration_s = model->scene.duration_s;
  settings_.realtime = realtime;
  settings_.core = core;
  settings_.quiet = true;
  settings_.own = std::move(own);
  mark(settings_.own.wrench, this);
  mark(settings_.own.forces, this);
  mark(settings_.own.torques, this);
  mark(settings_.own.muscles, this);
  settings_.live = &live_;
}

void Realtime::start() {
  const std::lock_guard lock(mutex_);
  if (started_) throw std::runtime_error("this run has begun already: make another");
  if (stopping_) throw std::runtime_error("this run was stopped: make another");
  auto engaged = std::make_shared<const Engaged>();
  process_ = getpid();
  // It ends by itself: nothing of the interpreter may be needed after `engaged`.
  std::thread([self = shared_from_this(), engaged = std::move(engaged)]() mutable {
    self->run();
    self.reset();
    engaged.reset();
  }).detach();
  started_ = true;
}

void Realtime::run() {
  std::optional<RealtimeRun> result;
  std::exception_ptr failure;
  std::shared_ptr<const py::object> raised;
  try {
    State state(*model);
    const Progress progress = [this](double, double) { return !is_stopping(); };
    result = run_realtime(*model, state, settings_, progress, {&newest});
  } catch (py::error_already_set& error) {
    const py::gil_scoped_acquire lock;
    if (error.trace()) PyException_SetTraceback(error.value().ptr(), error.trace().ptr());
    raised = {new py::object(error.value()), [](const py::object* object) {
                const py::gil_scoped_acquire again;
                delete object;
              }};
  } catch (...) {
    failure = std::current_exception();
  }
  const std::lock_guard lock(mutex_);
  raised_ = raised;
  result_ = std::move(result);
  failure_ = failure;
  has_ended_ = true;
  ended_.notify_all();
}

bool Realtime::wait(double seconds) {
  std::unique_lock lock(mutex_);
  if (started_ && process_ != getpid()) return true;
  return ended_.wait_for(lock, std::chrono::duration<double>(seconds), [this] { return !started_ || has_ended_; });
}

const RealtimeRun& Realtime::result() {
  const std::lock_guard lock(mutex_);
  if (!started_) throw std::runtime_error("the run has not begun");
  if (!has_ended_ && process_ != getpid()) throw std::runtime_error("the run is of the process that forked this one");
  if (!has_ended_) throw std::runtime_error("the run goes on: stop() it, or wait()");
  if (raised_) {
    PyErr_SetObject(py::type::of(*raised_).ptr(), raised_->ptr());
    throw py::error_already_set();
  }
  if (failure_) std::rethrow_exception(failure_);
  return *result_;
}

bool Realtime::running() {
  const std::lock_guard lock(mutex_);
  return started_ && !has_ended_;
}

void Realtime::send(const std::function<void(LiveInput&)>& change) {
  const std::lock_guard lock(input_mutex_);
  change(input_);
  ++input_.number;
  input_.stamp_ns = steady_now_ns();
  inputs_.draft() = input_;
  inputs_.publish();
}

/// Waits for the end, so long at most, and looks for Ctrl-C meanwhile. Whether it has come. A law of another run waits
/// no longer than that run goes on: two runs may wait for one another.
bool wait_for_end(Realtime& run, double left_s) {
  constexpr double kLook_s = 0.05;
  do {
    {
      const Unlocked others;
      if (run.wait(std::clamp(left_s, 0.0, kLook_s))) return true;
    }
    check_signals();
    if (run_of_law != nullptr && run_of_law->is_stopping()) return false;
    left_s -= kLook_s;
  } while (left_s > 0.0);
  return false;
}

constexpr double kForever_s = 1e9;

/// Ends the run and waits for its end, unless a law of its own asks: the end waits for the law.
void stop(Realtime& run) {
  run.ask_to_stop();
  if (run_of_law != &run) (void)wait_for_end(run, kForever_s);
}

/// What Python has of a run: the run ends when that is let go of.
struct RealtimeHandle : Constructed {
  explicit RealtimeHandle(std::shared_ptr<Realtime> of) : run(std::move(of)) {}
  RealtimeHandle(const RealtimeHandle&) = delete;
  RealtimeHandle& operator=(const RealtimeHandle&) = delete;
  /// Waits a while, so that the next run finds the cores free. Not longer: the garbage collector may be the caller, in
  /// a thread that has what a law needs.
  ~RealtimeHandle() {
    constexpr double kWhile_s = 1.0;
    run->ask_to_stop();
    if (run_of_law == run.get() || !run->running()) return;
    const py::gil_scoped_release others;
    (void)run->wait(kWhile_s);
  }

  std::shared_ptr<Realtime> run;
};

py::dict state_of(Realtime& run) {
  const Newest newest = run.newest.get();
  SeenTick seen(*run.model, newest.record, newest.after, newest.muscle_forces_N);
  py::dict state;
  for (const TickField& field : tick_fields()) {
    if (!field.is_in_python() || !field.is_in(*run.model)) continue;
    state[py::str(std::string(field.name))] = seen.value(field);
  }
  return state;
}

py::object report_of(Realtime& run) {
  const RealtimeRun& result = run.result();
  nlohmann::ordered_json json = verdict_json(result.recording.verdict);
  json.update(summarize(*run.model, result));
  return of_json(json);
}

bool wait_for(Realtime& run, const py::object& seconds) {
  if (!run.started()) throw std::runtime_error("the run has not begun");
  if (run_of_law == &run)
    throw std::runtime_error("a law cannot wait() for the end of its own run: the end waits for it");
  const double left_s = seconds.is_none() ? kForever_s : time_of(seconds, "seconds");
  if (!wait_for_end(run, left_s)) return false;
  (void)run.result();
  return true;
}

std::shared_ptr<RealtimeHandle> realtime_of(std::shared_ptr<const SceneHandle> scene, bool realtime, int core,
                                            py::object wrench, py::object forces, py::object torques,
                                            py::object muscles) {
  OwnControl own = own_control(model_of(*scene)->scene, std::move(wrench), std::move(forces), std::move(torques),
                               std::move(muscles));
  const Unlocked others;
  return std::make_shared<RealtimeHandle>(std::make_shared<Realtime>(std::move(scene), realtime, core, std::move(own)));
}

/// None leaves what it is.
void set_input(Realtime& self, const py::object& wrench, const py::object& shift_m, const py::object& turn_rad) {
  std::optional<Vector6d> w;
  std::optional<Eigen::Vector3d> shift, turn;
  if (!wrench.is_none()) w = vector(wrench, 6, "wrench");
  if (!shift_m.is_none()) shift = vector(shift_m, 3, "shift_m");
  if (!turn_rad.is_none()) turn = vector(turn_rad, 3, "turn_rad");
  self.send([&](LiveInput& input) {
    if (w) input.wrench = *w;
    if (shift) input.target_shift_m = *shift;
    if (turn) input.target_turn_rad = *turn;
  });
}

/// The function of a run, for the handle of it.
template <typename Result, typename... Arguments>
auto on(Result (*function)(Realtime&, Arguments...)) {
  return [function](const RealtimeHandle& self, Arguments... arguments) { return function(*self.run, arguments...); };
}

}  // namespace

void bind_realtime(py::module_& module) {
  py::class_<RealtimeHandle, std::shared_ptr<RealtimeHandle>>(
      module, "Realtime",
      R"(The two loops of a scene on threads of their own, as `thenar run --realtime`.

    with thenar.Realtime(scene, torques=law) as run:
        run.input(wrench=[0.2, 0, 0, 0, 0, 0])
        print(run.state()['position_m'])

Laws are called on the control thread. While one takes its time, the last frame stays in use and is then held: the
contact loop never waits for Python.)")
      .def(py::init(&realtime_of), py::arg("scene"), py::kw_only(), py::arg("realtime") = true, py::arg("core") = -1,
           py::arg("wrench") = py::none(), py::arg("forces") = py::none(), py::arg("torques") = py::none(),
           py::arg("muscles") = py::none(),
           R"(It lasts as long as the scene. realtime: ask for SCHED_FIFO and a core of its own; what
is refused is told in report. core: the contact thread's. Laws as of Simulation.)")
      .def(
          "start", [](const RealtimeHandle& self) { self.run->start(); }, "Begins; entering a `with` does so, too.")
      .def("stop", on(&stop),
           "Ends it, and waits for the threads; leaving a `with` does so, too. A law of its own does not wait.")
      .def("__enter__",
           [](const py::object& self) {
             self.attr("start")();
             return self;
           })
      .def("__exit__",
           [](const RealtimeHandle& self, const py::object& type, const py::object&, const py::object&) {
             stop(*self.run);
             // What a law raised ended the run: it is raised here, unless something else is on its way.
             if (type.is_none()) (void)self.run->result();
           })
      .def("wait", on(&wait_for), py::arg("seconds") = py::none(),
           "Until the end of the run, or so long. Whether it has ended. Raises what a law raised, and RuntimeError in "
           "a law of this run, whose end would never come.")
      .def_property_readonly("running", [](const RealtimeHandle& self) { return self.run->running(); })
      .def("state", on(&state_of), "The newest tick as a dict of copies; names and units as of Simulation.")
      .def("input", on(&set_input), py::arg("wrench") = py::none(), py::kw_only(), py::arg("shift_m") = py::none(),
           py::arg("turn_rad") = py::none(), R"(From the next tick on, until it is changed.

wrench: (6,) on the object, about its origin, world axes [N, N m].
shift_m, turn_rad: (3,) of the target against the task's, object axes at the start; within 50 mm and 0.5 rad an axis,
to which it goes at 50 mm/s and 1 rad/s.)")
      .def_property_readonly(
          "report", on(&report_of),
          R"(Of a run that has ended: outcome and reason, and its summary.json as `thenar run --realtime` writes it.

Raises what a law raised.)");
}

}  // namespace thenar::python
