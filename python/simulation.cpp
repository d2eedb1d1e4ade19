// SPDX-License-Identifier: Apache-2.0
#include "python/simulation.h"

#include <fmt/format.h>
#include <pybind11/stl/filesystem.h>

#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>
#include <utility>

#include "engine/loops/run_state.h"
#include "engine/recordings/recording_file.h"
#include "engine/results/record_state.h"
#include "engine/results/summary.h"
#include "engine/results/verdict.h"
#include "engine/scenes/scene_text.h"
#include "python/arrays.h"
#include "python/laws.h"
#include "python/tick_views.h"

namespace thenar::python {

namespace {

GraspRun run_of(const Model& model, const std::optional<LockstepSettings>& lockstep) {
  return lockstep ? GraspRun(model, *lockstep) : GraspRun(model);
}

py::array contacts_of(Simulation& simulation, py::handle owner) {
  // Of no tick nothing is known.
  if (simulation.run.state.tick == 0 || simulation.run.frame.sequence < 0)
    return py::array(contact_dtype(0, sizeof(ShownContact)), 0);
  const Picture& picture = simulation.picture();
  py::array array(contact_dtype(0, sizeof(ShownContact)), {std::ssize(picture.contacts)}, {sizeof(ShownContact)},
                  picture.contacts.data(), owner);
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

void step(Simulation& simulation, std::int64_t ticks) {
  if (ticks < 0) throw py::value_error("step takes a number of ticks, 0 or more");
  const Hold hold(simulation);
  SignalWatch watch;
  {
    const Unlocked others;
    simulation.ticks(ticks, false, watch);
  }
  watch.rethrow();
}

py::object run_until(Simulation& simulation, const py::object& until) {
  const double end_s = until.is_none() ? simulation.model->scene.duration_s : time_of(until, "until");
  if (!(std::abs(end_s) <= 1e6)) throw py::value_error("until must lie within a million seconds");
  const auto end = static_cast<std::int64_t>(std::ceil(end_s / simulation.model->scene.step_s - 1e-9));
  {
    const Hold hold(simulation);
    SignalWatch watch;
    {
      const Unlocked others;
      simulation.ticks(end - simulation.run.state.tick, simulation.model->scene.control.has_value(), watch);
    }
    watch.rethrow();
  }
  const Hold hold(simulation);
  return of_json(verdict_json(simulation.monitor.verdict()));
}

std::shared_ptr<Simulation> simulation_of(std::shared_ptr<const SceneHandle> scene, const py::object& lockstep,
                                          py::object wrench, py::object forces, py::object torques,
                                          py::object muscles) {
  const std::optional<LockstepSettings> settings = lockstep_of(lockstep);
  std::shared_ptr<const Model> model = model_of(*scene);
  OwnControl own =
      own_control(model->scene, std::move(wrench), std::move(forces), std::move(torques), std::move(muscles));
  const Unlocked others;
  return std::make_shared<Simulation>(std::move(scene), std::move(model), settings, std::move(own));
}

/// A property of a simulation that is open.
template <typename Get>
auto of(Get get) {
  return [get](const py::object& self) {
    auto& simulation = self.cast<Simulation&>();
    const Hold hold(simulation);
    return get(simulation, self);
  };
}

/// What the grip began to answer in the last tick, or None.
py::object reflex_of(const Simulation& simulation) {
  const ReflexReport& reflex = simulation.record.reflex;
  if (!simulation.record.controlled || reflex.event == ReflexEvent::kNone) return py::none();
  return py::dict(py::arg("event") = reflex.event == ReflexEvent::kLoad ? "load" : "slip",
                  py::arg("finger") = simulation.model->scene.hand.fingertips[reflex.finger].finger,
                  py::arg("rate_N_per_s") = reflex.rate_N_per_s);
}

/// A property for each field of a tick, and what is no field: arrays of the pulps and the contacts.
void bind_views(py::class_<Simulation, std::shared_ptr<Simulation>>& type) {
  for (const TickField& field : tick_fields()) {
    if (!field.is_in_python()) continue;
    type.def_property_readonly(
        std::string(field.name).c_str(), of([&field](Simulation& s, py::handle self) {
          return SeenTick(*s.model, s.record, s.run.state, s.run.controller.f_muscle).value(field, self);
        }),
        docstring(field).c_str());
  }
  type.def_property_readonly("reflex", of([](Simulation& s, py::handle) { return reflex_of(s); }),
                             R"(What the grip began to answer in the last tick; None: nothing.

A dict: event, 'load' or 'slip'; finger, which felt it most; rate_N_per_s, how fast its load changed, 0 for a slip.)")
      .def_property_readonly("displacement_m", of([](Simulation& s, py::handle self) {
                               py::list all;
                               for (const Eigen::MatrixX3d& u : s.run.state.u_m) all.append(view_of_matrix(u, self));
                               return py::tuple(all);
                             }),
                             "A (points, 3) array a finger: how far the pulp's surface is pushed in at its control "
                             "points, distal axes [m]. The surface moves by its negative.")
      .def_property_readonly("contacts", of([](Simulation& s, py::handle self) { return contacts_of(s, self); }),
                             R"(Structured array of all contacts: what states have of them.

As long as the array lives it shows the instant at which `contacts` was last read.)");
}

/// What it is of, what became of it, and what it is given.
void bind_state(py::class_<Simulation, std::shared_ptr<Simulation>>& type) {
  type.def_property_readonly("scene",
                             [](const Simulation& self) { return std::const_pointer_cast<SceneHandle>(self.scene); })
      .def_property_readonly("lost", of([](Simulation& s, py::handle) { return s.monitor.lost(); }),
                             "Whether the object is lost.")
      .def_property_readonly(
          "report", of([](Simulation& s, py::handle) { return of_json(verdict_json(s.monitor.verdict())); }),
          "What became of the grasp so far, as in summary.json: outcome, reason, held, lost_at_s, beyond.")
      .def_property_readonly("environment_wrench",
                             of([](Simulation& s, py::handle) { return copy(s.record.contact.environment.wrench); }),
                             "(6,) Of the environment on the object: force [N], and moment about its origin [N m], "
                             "world axes; zero without one.")
      .def_property(
          "input_wrench", of([](Simulation& s, py::handle) { return copy(s.input.wrench); }),
          [](Simulation& self, py::handle wrench) {
            const Vector6d given = vector(wrench, 6, "input_wrench");
            const Hold hold(self);
            self.input.wrench = given;
          },
          "(6,) Acts on the object until it is changed: force [N], and moment about its origin [N m], world axes.")
      .def_property(
          "target", of([](Simulation& s, py::handle) {
            return copy(s.run.state.X_WT.value_or(s.model->target(s.run.time_s())).matrix());
          }),
          [](Simulation& self, const py::object& target) {
            std::optional<Eigen::Isometry3d> X_WT;
            if (!target.is_none()) X_WT = pose(target, "target");
            const Hold hold(self);
            self.input.X_WT = X_WT;
          },
          "(4, 4) Where the object should be. Set: from the next tick on; None: where the task has it.");
}

/// What it is like for eyes.
void bind_shows(py::class_<Simulation, std::shared_ptr<Simulation>>& type) {
  type.def(
          "_record_now",
          [](Simulation& self, const std::filesystem::path& file) {
            const Hold hold(self);
            const Unlocked others;
            self.record_now(file);
          },
          py::arg("file"), "A recording of this instant alone.")
      .def("_repr_html_",
           [](const py::object& self) { return py::module_::import("thenar.notebook").attr("of_simulation")(self); })
      .def("__repr__", [](const Simulation& self) {
        if (self.busy.load()) return fmt::format("<thenar.Simulation of '{}', being stepped>", self.model->scene.name);
        return fmt::format("<thenar.Simulation of '{}' at {:.6g} s{}>", self.model->scene.name, self.run.time_s(),
                           self.closed ? ", closed"
                                       : (self.monitor.lost()        ? ", lost"
                                          : self.monitor.has_ended() ? ", failed"
                                                                     : ""));
      });
}

}  // namespace

Simulation::Simulation(std::shared_ptr<const SceneHandle> of_scene, std::shared_ptr<const Model> of_model,
                       std::optional<LockstepSettings> settings, OwnControl own)
    : scene(std::move(of_scene)),
      model(std::move(of_model)),
      lockstep(std::move(settings)),
      run(run_of(*model, lockstep)),
      record(model->scene.hand),
      monitor(*model),
      picture_(*model) {
  run.controller.own = std::move(own);
  record = tick_record(*model, run.state, TickReport(model->scene.hand), run.report);
}

Simulation::Simulation(const Simulation& other)
    : scene(other.scene),
      model(other.model),
      lockstep(other.lockstep),
      run(run_of(*model, lockstep)),
      input(other.input),
      record(other.record),
      sums(other.sums),
      monitor(other.monitor),
      picture_(*model) {
  run.go_on_as(other.run);
  const Picture now = other.picture_now();
  picture_ = now;  // A copy keeps the room that it has.
}

std::uint64_t Simulation::fingerprint() const {
  return state_fingerprint(*model, run.is_lockstep()) ^ std::hash<std::string>()(scene_text(model->scene, {}));
}

std::string Simulation::state() const {
  Simulation now(*this);
  StateWriter writer;
  now.members(writer);
  return sealed_state(fingerprint(), writer.bytes);
}

void Simulation::read(std::string_view members_of) {
  StateReader reader(members_of, *model);
  members(reader);
  StateReader::require(reader.left() == 0);
}

void Simulation::set_state(std::string_view bytes) {
  // Another one reads: what is refused changes nothing, and views of this one's arrays stay.
  Simulation read(scene, model, lockstep, run.controller.own);
  read.read(opened_state(fingerprint(), bytes));
  run.go_on_as(read.run);
  input = read.input;
  record = read.record;
  sums = read.sums;
  StateWriter judged;  // Of a monitor, which refers to its model, the members alone are assigned.
  judged(read.monitor);
  StateReader(judged.bytes, *model)(monitor);
  picture_ = std::as_const(read.picture_);
}

void Simulation::tick() {
  run.control_if_due();
  if (run.controlled) monitor.add(run.time_s(), run.report, run.controller.f_muscle);
  const TickReport contact = run.contact(input);
  record = tick_record(*model, run.state, contact, run.report);
  if (run.controlled) record_control(run.report, record);
  sums.add(record);
  monitor.add(record, run.state.pull_N);
}

void Simulation::record_now(const std::filesystem::path& file) {
  RecordingFile film(file, *model);
  film.add(picture(), record, run.controller.f_muscle);
  film.finish(monitor.verdict(), run.time_s());
}

const Picture& Simulation::picture() {
  if (picture_.snapshot.tick != run.state.tick) take_picture(run.state, run.memory, run.work, picture_);
  return picture_;
}

Picture Simulation::picture_now() const {
  if (picture_.snapshot.tick == run.state.tick) return picture_;
  Picture now(*model);
  take_picture(run.state, run.memory, run.work, now);
  return now;
}

Hold::Hold(Simulation& simulation) : simulation_(simulation) {
  if (simulation.busy.exchange(true, std::memory_order_acquire)) {
    throw std::runtime_error(
        "this simulation is being stepped, by another thread or by the step that called this law: make a copy() for "
        "each thread, and ask the period");
  }
  if (!simulation.closed) return;
  simulation.busy.store(false, std::memory_order_release);
  throw py::value_error("the simulation is closed");
}

std::optional<LockstepSettings> lockstep_of(const py::object& lockstep) {
  std::optional<LockstepSettings> settings;
  if (py::isinstance<py::dict>(lockstep)) {
    settings.emplace();
    for (const auto& [key, value] : lockstep.cast<py::dict>()) {
      const auto name = text_of(py::str(key), "a name in lockstep");
      if (name == "jitter_s") {
        settings->jitter_s = number(value, name);
        if (settings->jitter_s < 0.0) throw py::value_error("jitter_s is less than 0");
      } else if (name == "seed") {
        settings->seed = whole_number(value, name, 0, std::numeric_limits<std::int64_t>::max());
      } else {
        throw py::value_error(fmt::format("lockstep has no '{}': jitter_s, seed", name));
      }
    }
  } else if (lockstep.is(py::bool_(true))) {
    settings.emplace();
  } else if (!lockstep.is(py::bool_(false))) {
    throw py::type_error("lockstep takes True, False, or a dict of jitter_s and seed");
  }
  return settings;
}

namespace {

/// Copies the bytes of a state: while others have the interpreter, they may change an array.
std::string bytes_of(const py::buffer& state) {
  const py::buffer_info given = state.request();
  const bool is_dense = given.ndim == 1 && (given.strides[0] == 1 || given.size == 0);
  if (given.itemsize != 1 || !is_dense) throw py::type_error("a state is bytes, or an array of them, without gaps");
  return {static_cast<const char*>(given.ptr), static_cast<std::size_t>(given.size)};
}

void bind_saving(py::class_<Simulation, std::shared_ptr<Simulation>>& type) {
  type.def(
          "state",
          [](Simulation& self) {
            const Hold hold(self);
            std::string bytes;
            {
              const Unlocked others;
              bytes = self.state();
            }
            return py::bytes(bytes);
          },
          R"(All of the run as bytes, but its laws: the controller's memory, that of the contacts, frames under way.

For set_state() of a simulation of the same scene, in this process or another one of the same version and machine.
pickle saves them; so does numpy, as numpy.frombuffer(state, numpy.uint8).)")
      .def(
          "set_state",
          [](Simulation& self, const py::buffer& state) {
            const std::string bytes = bytes_of(state);
            const Hold hold(self);
            const Unlocked others;
            self.set_state(bytes);
          },
          py::arg("state"), R"(Goes on as the run did whose state() this is: with the same bits as its copy().

state: bytes, or an array of bytes, such as numpy.load() gives. The laws stay. Raises ValueError, and changes nothing,
if the bytes are not whole, or the state of another scene: each value of both has to be the same. Like a pickle, a state
is to come from somebody you trust.)");
}

}  // namespace

void bind_simulation(py::module_& module) {
  py::class_<Simulation, std::shared_ptr<Simulation>> type(module, "Simulation", R"(A scene that is stepped.

In one loop, as `thenar run`, or on the virtual clock of two loops, as `thenar run --lockstep`: the same bits as there.
Arrays are read-only views of the engine's memory: they show the newest tick; .copy() keeps one. Names and units are
those of recordings. To lose the object is no error: see lost and report.)");
  bind_views(type);
  type.def(py::init(&simulation_of), py::arg("scene"), py::kw_only(), py::arg("lockstep") = false,
           py::arg("wrench") = py::none(), py::arg("forces") = py::none(), py::arg("torques") = py::none(),
           py::arg("muscles") = py::none(), R"(Makes a run that has not begun.

lockstep: True, or {'jitter_s': 2e-3, 'seed': 1}: frames come late, as between threads.
wrench, forces, torques, muscles: functions of a Period, each instead of that part of the published controller.)")
      .def("step", &step, py::arg("ticks") = 1,
           "So many contact ticks, with the control ticks that are due. Lets other threads run.")
      .def(
          "run", &run_until, py::arg("until") = py::none(),
          R"(Goes on until a simulated time (seconds, or text such as '500 ms'), the scene's end, or the object is lost.

Returns report.)")
      .def(
          "copy",
          [](Simulation& self) {
            const Hold hold(self);
            const Unlocked others;
            return std::make_shared<Simulation>(self);
          },
          "A run that goes on as this one would, by itself.")
      .def(
          "close",
          [](Simulation& self) {
            if (self.closed) return;
            const Hold hold(self);
            self.closed = true;
            self.run.controller.own = {};
          },
          "No more steps and views, and its laws are let go; views that are there stay. Leaving a `with` does so, too.")
      .def("__enter__", [](const py::object& self) { return self; })
      .def("__exit__", [](const py::object& self, const py::args&) { self.attr("close")(); });
  bind_saving(type);
  bind_state(type);
  bind_shows(type);
}

}  // namespace thenar::python
