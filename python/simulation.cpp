#include "python/simulation.h"

#include <fmt/format.h>
#include <pybind11/stl/filesystem.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "engine/results/recording_file.h"
#include "engine/results/summary.h"
#include "engine/results/verdict.h"
#include "python/arrays.h"
#include "python/laws.h"
#include "python/touch.h"

namespace thenar::python {

namespace {

GraspRun run_of(const Model& model, const std::optional<LockstepSettings>& lockstep) {
  return lockstep ? GraspRun(model, *lockstep) : GraspRun(model);
}

/// One contact, as recordings have it.
py::dtype contact_dtype() {
  static_assert(sizeof(Eigen::Index) == 8 && sizeof(int) == 4);
  return structure({{"finger", "i4", 1, offsetof(ShownContact, finger)},
                    {"control_point", "i8", 1, offsetof(ShownContact, control_point)},
                    {"point_m", "f8", 3, offsetof(ShownContact, point_m)},
                    {"normal", "f8", 3, offsetof(ShownContact, normal)},
                    {"force_N", "f8", 3, offsetof(ShownContact, force_N)},
                    {"normal_N", "f8", 1, offsetof(ShownContact, normal_N)},
                    {"friction_N", "f8", 1, offsetof(ShownContact, friction_N)},
                    {"share", "f8", 1, offsetof(ShownContact, share)}},
                   sizeof(ShownContact));
}

py::array contacts_of(Simulation& simulation, py::handle owner) {
  // Of no tick nothing is known.
  if (simulation.run.state.tick == 0 || simulation.run.frame.sequence < 0) return py::array(contact_dtype(), 0);
  const Picture& picture = simulation.picture();
  py::array array(contact_dtype(), {std::ssize(picture.contacts)}, {sizeof(ShownContact)}, picture.contacts.data(),
                  owner);
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

void step(Simulation& simulation, std::int64_t ticks) {
  if (ticks < 0) throw py::value_error("step takes a number of ticks, 0 or more");
  const Hold hold(simulation);
  SignalWatch watch;
  {
    const py::gil_scoped_release others;
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
      const py::gil_scoped_release others;
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
  const py::gil_scoped_release others;
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

void bind_touch(py::class_<Simulation, std::shared_ptr<Simulation>>& type) {
  const auto fingers = [](const Simulation& s) { return s.model->feels() ? s.model->fingers() : 0; };
  const auto gripping = [=](const Simulation& s) { return s.model->scene.control ? fingers(s) : 0; };
  for (const TouchNumber& number : kTouchNumbers) {
    type.def_property_readonly(number.name, of([=](Simulation& s, py::handle self) {
                                 return view_of_column<Touch>(&(s.run.state.touch.data()->*number.field), fingers(s),
                                                              self);
                               }),
                               number.doc);
  }
  type.def_property_readonly("felt_tangential_N", of([=](Simulation& s, py::handle self) {
                               return view_of_rows<Touch>(s.run.state.touch.data()->tangential_N.data(), fingers(s),
                                                          self);
                             }),
                             "(fingers, 3) Likewise: load across it, world axes [N].")
      .def_property_readonly("friction_felt", of([=](Simulation& s, py::handle self) {
                               return view(s.record.reflex.friction.data(), {gripping(s)}, {1}, self);
                             }),
                             "(fingers,) Likewise: friction that the hand has felt last, or expects; 0 before it does.")
      .def_property_readonly("cone_friction", of([=](Simulation& s, py::handle self) {
                               return view_of_column<ContactGrip>(&s.record.reflex.grips.data()->friction, gripping(s),
                                                                  self);
                             }),
                             "(fingers,) Likewise: that of the cones that the controller plans with.")
      .def_property_readonly("squeeze_N", of([=](Simulation& s, py::handle self) {
                               return view_of_column<ContactGrip>(&s.record.reflex.grips.data()->internal_force_N,
                                                                  gripping(s), self);
                             }),
                             "(fingers,) Likewise: by how much it lets each finger squeeze [N].")
      .def_property_readonly("reflex", of([](Simulation& s, py::handle) { return reflex_of(s); }),
                             R"(What the grip began to answer in the last tick; None: nothing.

A dict: event, 'load' or 'slip'; finger, which felt it most; rate_N_per_s, how fast its load changed, 0 for a slip.)");
}

void bind_views(py::class_<Simulation, std::shared_ptr<Simulation>>& type) {
  const auto add = [&type](const char* name, auto get, const char* doc) {
    type.def_property_readonly(name, of(get), doc);
  };
  // Of joints that turn, or of slides: the others are none.
  const auto per_joint = [&](const char* name, bool slides, auto get, const char* doc) {
    add(
        name,
        [slides, get](Simulation& s, py::handle self) {
          const JointVector& all = get(s);
          const bool are_there = s.model->scene.hand.slides == slides;
          return view(all.data(), {are_there ? all.size() : 0}, {1}, self);
        },
        doc);
  };
  const auto q = [](const Simulation& s) -> const JointVector& { return s.run.state.q; };
  per_joint("q_rad", false, q, "(joints,) Joint angles [rad]; none where fingertips are on slides.");
  per_joint("q_m", true, q, "(joints,) How far fingertips on slides are from where they began [m]; else none.");
  add(
      "object", [](Simulation& s, py::handle self) { return view_of_pose(s.run.state.X_WO, self); },
      "(4, 4) Pose of the object, world = hand frame; [m].");
  add(
      "force_N",
      [](Simulation& s, py::handle self) {
        return view_of_rows<FingerLoad>(s.run.state.load[0].force_N.data(), s.model->fingers(), self);
      },
      "(fingers, 3) Force of each finger on the object, world axes [N].");
  add(
      "centre_m",
      [](Simulation& s, py::handle self) {
        return view_of_rows<FingerLoad>(s.run.state.load[0].centre_m.data(), s.model->fingers(), self);
      },
      "(fingers, 3) Pressure centre of each finger, world [m].");
  add(
      "normal",
      [](Simulation& s, py::handle self) {
        return view_of_rows<FingerLoad>(s.run.state.load[0].normal.data(), s.model->fingers(), self);
      },
      "(fingers, 3) Into the object, mean of each finger's contacts, world.");
  add(
      "normal_N",
      [](Simulation& s, py::handle self) {
        return view_of_column<NormalTangential>(&s.record.force[0].normal_N, s.model->fingers(), self);
      },
      "(fingers,) Normal part of force_N [N].");
  add(
      "tangential_N",
      [](Simulation& s, py::handle self) {
        return view_of_column<NormalTangential>(&s.record.force[0].tangential_N, s.model->fingers(), self);
      },
      "(fingers,) Tangential part of force_N [N].");
  add(
      "desired_N",
      [](Simulation& s, py::handle self) {
        return view_of_rows<Eigen::Vector3d>(s.record.desired_N[0].data(), s.model->fingers(), self);
      },
      "(fingers, 3) What the controller asks of each finger, world axes [N].");
  const auto per_finger = [&](const char* name, PerFinger<double> TickRecord::*field, const char* doc) {
    add(
        name,
        [field](Simulation& s, py::handle self) {
          return view((s.record.*field).data(), {s.model->fingers()}, {1}, self);
        },
        doc);
  };
  per_finger("margin", &TickRecord::margin,
             "(fingers,) Friction to spare: 1 without tangential load, 0 as it slides; NaN without load.");
  per_finger("slip_m", &TickRecord::slip_m,
             "(fingers,) How far each patch has gone on the object since it touched [m].");
  per_finger("spin_rad", &TickRecord::spin_rad, "(fingers,) How far each has turned [rad].");
  per_finger("sliding_share", &TickRecord::sliding_share, "(fingers,) Share of the normal force on points that slide.");
  per_finger("creep_m_per_s", &TickRecord::creep_m_per_s, "(fingers,) Of the fastest point that should stick [m/s].");
  add(
      "position_m", [](Simulation& s, py::handle self) { return view_of_vector(s.record.position_m, self); },
      "(3,) Of the object from its start, object axes at the start [m].");
  add(
      "path_target_m", [](Simulation& s, py::handle self) { return view_of_vector(s.record.target_m, self); },
      "(3,) Where it should be, likewise [m].");
  add(
      "torques_Nm",
      [](Simulation& s, py::handle self) { return view_of_vector(s.run.report.torques_desired_Nm, self); },
      "(joints,) What the controller asks of the joints [N m].");
  add(
      "muscles_N",
      [](Simulation& s, py::handle self) {
        return view(s.run.controller.f_muscle.data(),
                    {s.model->scene.has_muscles() ? s.run.controller.f_muscle.size() : 0}, {1}, self);
      },
      "(muscles,) Muscle forces [N].");
  const auto stops = [](const Simulation& s) -> const JointVector& { return s.record.contact.stop_Nm; };
  per_joint("stop_Nm", false, stops, "(joints,) What the ends of the joints' ranges bear [N m]; none of slides.");
  per_joint("stop_N", true, stops, "(joints,) What the ends of slides bear [N]; else none.");
  add(
      "displacement_m",
      [](Simulation& s, py::handle self) {
        py::list all;
        for (const Eigen::MatrixX3d& u : s.run.state.u_m) all.append(view_of_matrix(u, self));
        return py::tuple(all);
      },
      "A (points, 3) array a finger: how far the pulp's surface is pushed in at its control points, distal axes [m]. "
      "The surface moves by its negative.");
  add(
      "contacts", [](Simulation& s, py::handle self) { return contacts_of(s, self); },
      R"(Structured array of all contacts: finger, control_point, point_m, normal, force_N, normal_N, friction_N, share.

world axes; normal points into the object, and force_N acts on the object. normal_N and friction_N are what the cone
bounds: at an edge, where a contact leans, not the parts of force_N along the normal and across it. share is the part of
the control point's cell that the contact stands for.
As long as the array lives it shows the instant at which `contacts` was last read.)");
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
}

void Simulation::tick() {
  run.control_if_due();
  if (run.controlled) monitor.add(run.time_s(), run.report, run.controller.f_muscle);
  const TickReport contact = run.contact(input);
  record = tick_record(*model, run.state, contact, run.report);
  if (run.controlled) record_control(run.report, record);
  sums.add(record);
  monitor.add(record);
}

void Simulation::record_now(const std::filesystem::path& file) {
  RecordingFile film(file, *model);
  film.add(picture(), record, run.controller.f_muscle);
  film.finish(monitor.verdict(), run.time_s());
}

const Picture& Simulation::picture() {
  if (picture_.snapshot.tick != run.state.tick) take_picture(run.state, run.work, picture_);
  return picture_;
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
      const auto name = py::str(key).cast<std::string>();
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

bool SignalWatch::operator()(std::int64_t tick) {
  constexpr std::int64_t kEvery = 1024;
  if (tick % kEvery != kEvery - 1) return false;
  const py::gil_scoped_acquire lock;
  raised_ = PyErr_CheckSignals() != 0;
  return raised_;
}

void bind_simulation(py::module_& module) {
  py::class_<Simulation, std::shared_ptr<Simulation>> type(module, "Simulation", R"(A scene that is stepped.

In one loop, as `thenar run`, or on the virtual clock of two loops, as `thenar run --lockstep`: the same bits as there.
Arrays are read-only views of the engine's memory: they show the newest tick; .copy() keeps one. Names and units are
those of recordings. To lose the object is no error: see lost and report.)");
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
            const py::gil_scoped_release others;
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
      .def_property_readonly("scene",
                             [](const Simulation& self) { return std::const_pointer_cast<SceneHandle>(self.scene); })
      .def_property_readonly("time_s", of([](Simulation& s, py::handle) { return s.run.time_s(); }), "Simulated time.")
      .def_property_readonly("tick", of([](Simulation& s, py::handle) { return s.run.state.tick; }),
                             "Contact ticks done.")
      .def_property_readonly("held", of([](Simulation& s, py::handle) { return s.record.contact.held; }),
                             "An old drive is held, since frames came too late.")
      .def_property_readonly("lost", of([](Simulation& s, py::handle) { return s.monitor.lost(); }),
                             "Whether the object is lost.")
      .def_property_readonly(
          "report", of([](Simulation& s, py::handle) { return of_json(verdict_json(s.monitor.verdict())); }),
          "What became of the grasp so far, as in summary.json: outcome, reason, held, lost_at_s, beyond.")
      .def_property_readonly("residual", of([](Simulation& s, py::handle) { return s.record.contact.solve.residual; }),
                             "Of the contact solve: natural map [no unit].")
      .def_property_readonly("sweeps", of([](Simulation& s, py::handle) { return s.record.contact.solve.sweeps; }))
      .def_property_readonly("penetration_m",
                             of([](Simulation& s, py::handle) { return s.record.contact.penetration_m; }),
                             "The deepest control point in the object.")
      .def_property_readonly("phase", of([](Simulation& s, py::handle) { return s.record.phase; }),
                             "Which phase of the task runs, from 0 on; as many as there are: all are done; -1: it "
                             "has none.")
      .def_property_readonly("environment_wrench",
                             of([](Simulation& s, py::handle) { return copy(s.record.contact.environment.wrench); }),
                             "(6,) Of the environment on the object: force [N], and moment about its origin [N m], "
                             "world axes; zero without one.")
      .def_property_readonly("environment_normal_N",
                             of([](Simulation& s, py::handle) { return s.record.contact.environment.normal_N; }),
                             "Sum of the normal forces there.")
      .def_property_readonly("environment_contacts",
                             of([](Simulation& s, py::handle) { return s.record.contact.environment.contacts; }),
                             "Contacts with the environment within the band; those that carry force are fewer.")
      .def_property_readonly("environment_penetration_m",
                             of([](Simulation& s, py::handle) { return s.record.contact.environment.penetration_m; }),
                             "How far object and environment give way to each other, at the most.")
      .def_property_readonly("rotation_error_rad",
                             of([](Simulation& s, py::handle) { return s.record.rotation_error_rad; }),
                             "Angle between the object and its target.")
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
          "(4, 4) Where the object should be. Set: from the next tick on; None: where the task has it.")
      .def(
          "_record_now",
          [](Simulation& self, const std::filesystem::path& file) {
            const Hold hold(self);
            const py::gil_scoped_release others;
            self.record_now(file);
          },
          py::arg("file"), "A recording of this instant alone.")
      .def("_repr_html_",
           [](const py::object& self) { return py::module_::import("thenar.notebook").attr("of_simulation")(self); })
      .def("__enter__", [](const py::object& self) { return self; })
      .def("__exit__", [](const py::object& self, const py::args&) { self.attr("close")(); })
      .def("__repr__", [](const Simulation& self) {
        if (self.busy.load()) return fmt::format("<thenar.Simulation of '{}', being stepped>", self.model->scene.name);
        return fmt::format("<thenar.Simulation of '{}' at {:.6g} s{}>", self.model->scene.name, self.run.time_s(),
                           self.closed ? ", closed"
                                       : (self.monitor.lost()        ? ", lost"
                                          : self.monitor.has_ended() ? ", failed"
                                                                     : ""));
      });
  bind_views(type);
  bind_touch(type);
}

}  // namespace thenar::python
