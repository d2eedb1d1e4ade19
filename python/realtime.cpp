#include "python/realtime.h"

#include <fmt/format.h>

#include <atomic>
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
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
/// contact loop never waits for Python.
class Realtime {
 public:
  Realtime(std::shared_ptr<const SceneHandle> scene, bool realtime, int core, OwnControl own);
  ~Realtime();
  Realtime(const Realtime&) = delete;
  Realtime& operator=(const Realtime&) = delete;

  void start();
  /// Ends the run and waits for it; without the interpreter's lock.
  void stop();
  /// Waits for its end, so long at most. Whether it has come.
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
  std::mutex joining_;
  std::mutex mutex_;
  std::condition_variable ended_;
  bool started_ = false, has_ended_ = false;
  std::optional<RealtimeRun> result_;
  std::exception_ptr failure_;                ///< Of ours, or
  std::shared_ptr<const py::object> raised_;  ///< an exception of Python, which may be raised again and again.
  std::thread thread_;
};

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
  settings_.live = &live_;
}

/// Those that may be running: the interpreter's end ends them first.
std::mutex all_mutex;
std::set<Realtime*> all_runs;

Realtime::~Realtime() {
  const py::gil_scoped_release others;  // for a law may be waiting for the lock
  {
    const std::lock_guard lock(all_mutex);
    all_runs.erase(this);
  }
  stop();
}

void stop_all() {
  const py::gil_scoped_release others;
  const std::lock_guard lock(all_mutex);
  for (Realtime* run : all_runs) run->stop();
}

void Realtime::start() {
  if (started_) throw std::runtime_error("this run has begun already: make another");
  if (stopping_) throw std::runtime_error("this run was stopped: make another");
  {
    const std::lock_guard lock(all_mutex);
    all_runs.insert(this);
  }
  {
    const std::lock_guard lock(mutex_);
    started_ = true;
  }
  thread_ = std::thread([this] { run(); });
}

void Realtime::run() {
  std::optional<RealtimeRun> result;
  std::exception_ptr failure;
  std::shared_ptr<const py::object> raised;
  try {
    State state(*model);
    const Progress progress = [this](double, double) { return !stopping_.load(std::memory_order_relaxed); };
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

void Realtime::stop() {
  stopping_.store(true, std::memory_order_relaxed);
  if (is_in_law()) return;  // The run's end waits for the law.
  const std::lock_guard lock(joining_);
  if (thread_.joinable()) thread_.join();
}

bool Realtime::wait(double seconds) {
  std::unique_lock lock(mutex_);
  return ended_.wait_for(lock, std::chrono::duration<double>(seconds), [this] { return has_ended_; });
}

const RealtimeRun& Realtime::result() {
  const std::lock_guard lock(mutex_);
  if (!started_) throw std::runtime_error("the run has not begun");
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

/// Waits, and looks for Ctrl-C meanwhile.
bool wait_for(Realtime& run, const py::object& seconds) {
  constexpr double kLook_s = 0.05;
  if (!run.started()) throw std::runtime_error("the run has not begun");
  double left_s = seconds.is_none() ? 1e9 : time_of(seconds, "seconds");
  for (;;) {
    bool ended = false;
    {
      const py::gil_scoped_release others;
      ended = run.wait(std::min(left_s, kLook_s));
    }
    if (ended) {
      (void)run.result();
      return true;
    }
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    left_s -= kLook_s;
    if (left_s <= 0.0) return false;
  }
}

std::unique_ptr<Realtime> realtime_of(std::shared_ptr<const SceneHandle> scene, bool realtime, int core,
                                      py::object wrench, py::object forces, py::object torques, py::object muscles) {
  OwnControl own = own_control(model_of(*scene)->scene, std::move(wrench), std::move(forces), std::move(torques),
                               std::move(muscles));
  const py::gil_scoped_release others;
  return std::make_unique<Realtime>(std::move(scene), realtime, core, std::move(own));
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

}  // namespace

void bind_realtime(py::module_& module) {
  py::module_::import("atexit").attr("register")(py::cpp_function(&stop_all));
  const auto ends = [](Realtime& self) {
    const py::gil_scoped_release others;
    self.stop();
  };
  py::class_<Realtime>(module, "Realtime",
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
      .def("start", &Realtime::start, "Begins; entering a `with` does so, too.")
      .def("stop", ends, "Ends it, and waits for the threads; leaving a `with` does so, too.")
      .def(
          "__enter__",
          [](Realtime& self) -> Realtime& {
            self.start();
            return self;
          },
          py::return_value_policy::reference)
      .def("__exit__",
           [ends](Realtime& self, const py::object& type, const py::object&, const py::object&) {
             ends(self);
             // What a law raised ended the run: it is raised here, unless something else is on its way.
             if (type.is_none()) (void)self.result();
           })
      .def("wait", &wait_for, py::arg("seconds") = py::none(),
           "Until the end of the run, or so long. Whether it has ended. Raises what a law raised.")
      .def_property_readonly("running", &Realtime::running)
      .def("state", &state_of, "The newest tick as a dict of copies; names and units as of Simulation.")
      .def("input", &set_input, py::arg("wrench") = py::none(), py::kw_only(), py::arg("shift_m") = py::none(),
           py::arg("turn_rad") = py::none(), R"(From the next tick on, until it is changed.

wrench: (6,) on the object, about its origin, world axes [N, N m].
shift_m, turn_rad: (3,) of the target against the task's, object axes at the start; within 50 mm and 0.5 rad an axis,
to which it goes at 50 mm/s and 1 rad/s.)")
      .def_property_readonly(
          "report", &report_of,
          R"(Of a run that has ended: outcome and reason, and its summary.json as `thenar run --realtime` writes it.

Raises what a law raised.)");
}

}  // namespace thenar::python
