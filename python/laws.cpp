// SPDX-License-Identifier: Apache-2.0
#include "python/laws.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "engine/control/control_tick.h"
#include "python/arrays.h"
#include "python/interpreter.h"
#include "python/touch.h"

namespace thenar::python {

namespace {

/// A control period as its law sees it; empty when it is over.
struct Period : Constructed {
  explicit Period(ControlPeriod* of) : period(of) {}

  ControlPeriod* period;

  [[nodiscard]] ControlPeriod& now() const {
    if (period == nullptr) throw std::runtime_error("this control period is over: copy what is to be kept");
    return *period;
  }
};

using PeriodClass = py::class_<Period, std::shared_ptr<Period>>;

/// A function of Python's, to be called and let go of with the interpreter's lock, whoever does so.
std::shared_ptr<const py::object> shared(py::object function) {
  return {new py::object(std::move(function)), [](const py::object* object) {
            const py::gil_scoped_acquire lock;
            delete object;
          }};
}

/// Calls the law on this period, and gives its answer to `read` while it lives.
template <typename Read>
auto ask(const std::shared_ptr<const py::object>& law, ControlPeriod& period, Read&& read) {
  const py::gil_scoped_acquire lock;
  const auto seen = std::make_shared<Period>(&period);
  struct Closing {
    ~Closing() { period.period = nullptr; }
    Period& period;
  } const closing{*seen};
  return read((*law)(seen));
}

void expect_callable(const py::object& law, const char* name) {
  if (!law.is_none() && PyCallable_Check(law.ptr()) == 0) {
    throw py::type_error(fmt::format("{} takes a function of a control period, or None", name));
  }
}

FingerForces forces_of(py::handle answer, int fingers) {
  return matrix(answer, fingers, 3, "what the law 'forces' returned").transpose();
}

/// What the fingertips are known to feel: fingertips.touch.delay late, where there is control.
const PerFinger<Touch>& felt_in(const ControlPeriod& period) {
  if (!period.model.feels() || !period.controller.afference.is_needed()) return period.snapshot.touch;
  const auto delay = ticks_of(period.model, period.model.scene.fingertips->touch->delay_s);
  return period.controller.afference.at(period.now - delay).snapshot.touch;
}

/// One number a finger, of what there is one of for each that feels.
template <typename T, typename Get>
Array column(const PerFinger<T>& all, Get get) {
  Eigen::VectorXd numbers(std::ssize(all));
  std::ranges::transform(all, numbers.begin(), get);
  return copy(numbers);
}

void bind_touch(PeriodClass& type) {
  for (const TouchNumber& number : kTouchNumbers) {
    type.def_property_readonly(
        number.name, [number](const Period& self) { return column(felt_in(self.now()), number.field); }, number.doc);
  }
  type.def_property_readonly(
          "felt_tangential_N",
          [](const Period& self) {
            const PerFinger<Touch>& felt = felt_in(self.now());
            Eigen::MatrixXd rows(std::ssize(felt), 3);
            for (std::size_t k = 0; k < felt.size(); ++k) rows.row(static_cast<Eigen::Index>(k)) = felt[k].tangential_N;
            return copy(rows);
          },
          "(fingers, 3) Likewise: load across it, world axes [N].")
      .def_property_readonly(
          "friction_felt",
          [](const Period& self) { return column(self.now().report.reflex.friction, std::identity()); },
          "(fingers,) Likewise: friction that the hand has felt last, or expects.")
      .def_property_readonly(
          "cone_friction",
          [](const Period& self) { return column(self.now().report.reflex.grips, &ContactGrip::friction); },
          "(fingers,) Likewise: that of the cones of published_forces().")
      .def_property_readonly(
          "squeeze_N",
          [](const Period& self) { return column(self.now().report.reflex.grips, &ContactGrip::internal_force_N); },
          "(fingers,) Likewise: their squeeze [N].");
}

/// A property of a period that has one row a finger: get(period, k).
template <typename Get>
auto of_fingers(Get get) {
  return [get](const Period& self) {
    ControlPeriod& period = self.now();
    FingerForces rows(3, period.model.fingers());
    for (int k = 0; k < period.model.fingers(); ++k) rows.col(k) = get(period, k);
    return copy(rows.transpose());
  };
}

/// The time, the hand's posture, and the object and its target.
void bind_state(PeriodClass& type) {
  type.def_property_readonly(
          "time_s", [](const Period& self) { return self.now().time_s(); }, "Of what is seen.")
      .def_property_readonly(
          "now_s", [](const Period& self) { return self.now().now_s(); }, "When the period begins.")
      .def_property_readonly(
          "known_gravity", [](const Period& self) { return copy(self.now().known_gravity()); },
          "(3,) Gravity in the hand's frame [m/s^2]: with control.anticipation the arm's swing is in it.")
      .def_property_readonly(
          "period_s", [](const Period& self) { return self.now().controller.period_s; },
          "Simulated time since the last period.")
      .def_property_readonly(
          "held", [](const Period& self) { return self.now().snapshot.held; },
          "Frames came too late: an old drive is held, and nothing acts that is asked for.")
      .def_property_readonly(
          "q_rad", [](const Period& self) { return copy(self.now().snapshot.q); },
          "(joints,) Joint angles; of slides in m.")
      .def_property_readonly(
          "object", [](const Period& self) { return copy(self.now().snapshot.X_WO.matrix()); },
          "(4, 4) Pose of the object.")
      .def_property_readonly(
          "target", [](const Period& self) { return copy(self.now().target().matrix()); },
          "(4, 4) Where the object should be.")
      .def_property_readonly(
          "error", [](const Period& self) { return copy(self.now().error()); },
          "(6,) From the object to its target: translation [m], then rotation vector [rad].");
}

/// The fingers' contacts with the object, and how joints move them.
void bind_contacts(PeriodClass& type) {
  type.def_property_readonly("force_N", of_fingers([](ControlPeriod& p, int k) { return p.snapshot.load[k].force_N; }),
                             "(fingers, 3) Force of each finger on the object.")
      .def_property_readonly("point_m", of_fingers([](ControlPeriod& p, int k) { return p.contacts()[k].point_m; }),
                             "(fingers, 3) Where each finger acts on the object.")
      .def_property_readonly(
          "normal", of_fingers([](ControlPeriod& p, int k) -> Eigen::Vector3d { return p.contacts()[k].axes.col(0); }),
          "(fingers, 3) Into the object, there.")
      .def(
          "jacobian",
          [](const Period& self, int finger) {
            ControlPeriod& period = self.now();
            if (finger < 0 || finger >= period.model.fingers()) {
              throw py::index_error(fmt::format("there is no finger {}: 0 to {}", finger, period.model.fingers() - 1));
            }
            const Fingertip& tip = period.model.scene.hand.fingertips[finger];
            Eigen::MatrixXd all = Eigen::MatrixXd::Zero(3, std::ssize(period.model.scene.hand.joints));
            all.middleCols(tip.first_joint, tip.joints) = period.jacobian(finger).leftCols(tip.joints);
            return copy(all);
          },
          py::arg("finger"),
          "(3, joints) Velocity of point_m[finger] for the joints' speeds; zero for other fingers' joints.");
}

/// Loads by weight, and the muscles' moment arms.
void bind_loads(PeriodClass& type) {
  type.def_property_readonly(
          "gravity_Nm",
          [](const Period& self) {
            const ControlPeriod& p = self.now();
            return copy(gravity_torques(p.model.scene.hand, p.controller.pose, p.known_gravity()));
          },
          "(joints,) What bears the hand's own weight.")
      .def_property_readonly(
          "weight",
          [](const Period& self) {
            const ControlPeriod& p = self.now();
            return copy(p.model.weight(p.snapshot.X_WO, p.known_gravity()));
          },
          "(6,) The object's weight, about its origin [N, N m].")
      .def_property_readonly(
          "moment_arms_m", [](const Period& self) { return copy(self.now().moment_arms()); },
          "(joints, muscles) H of torques = H f.");
}

/// Desired wrench, forces and torques: by the law given for them, or as published.
void bind_desired(PeriodClass& type) {
  type.def(
          "wrench", [](const Period& self) { return copy(self.now().wrench()); },
          "(6,) W^d: asked of the fingers, about the object's origin [N, N m].")
      .def(
          "forces", [](const Period& self) { return copy(self.now().forces().transpose()); },
          "(fingers, 3) f^d: desired force of each finger on the object [N].")
      .def(
          "torques", [](const Period& self) { return copy(self.now().torques()); },
          "(joints,) tau^d: desired joint torques [N m].");
}

/// The answers of the published laws.
void bind_published(PeriodClass& type) {
  type.def(
          "published_wrench", [](const Period& self) { return copy(published_wrench(self.now())); },
          "(6,) As the PID has it. At most once a period, as all published laws.")
      .def(
          "published_forces",
          [](const Period& self) -> py::object {
            const auto f = published_forces(self.now());
            return f ? py::object(copy(f->transpose())) : py::none();
          },
          "(fingers, 3) Within the friction cones, for wrench(); None if there are none.")
      .def(
          "published_torques", [](const Period& self) { return copy(published_torques(self.now())); },
          "(joints,) Of the force control, for forces().")
      .def(
          "published_muscle_forces", [](const Period& self) { return copy(published_muscle_forces(self.now())); },
          "(muscles,) The least that give torques() [N].");
}

}  // namespace

OwnControl own_control(const Scene& scene, py::object wrench, py::object forces, py::object torques,
                       py::object muscles) {
  expect_callable(wrench, "wrench");
  expect_callable(forces, "forces");
  expect_callable(torques, "torques");
  expect_callable(muscles, "muscles");
  if (!muscles.is_none() && !scene.has_muscles()) {
    throw py::value_error("muscles: torques drive the joints of this scene, and no muscles");
  }
  const bool asks = !torques.is_none() || (scene.control && !scene.control->drive) || !muscles.is_none();
  if (!asks && (!wrench.is_none() || !forces.is_none())) {
    throw py::value_error("nothing in this scene asks for wrench or forces: a table or constant torques drive it");
  }
  if (!torques.is_none() && muscles.is_none() && scene.control && scene.control->drive &&
      scene.control->drive->muscles) {
    throw py::value_error("torques: control.drive gives the muscle forces of this scene, which asks for no torques");
  }
  OwnControl own;
  if (!wrench.is_none()) {
    own.wrench = [law = shared(std::move(wrench))](ControlPeriod& period) -> Vector6d {
      return ask(law, period, [](const py::object& answer) -> Vector6d {
        return vector(answer, 6, "what the law 'wrench' returned");
      });
    };
  }
  if (!forces.is_none()) {
    own.forces = [law = shared(std::move(forces))](ControlPeriod& period) {
      return ask(law, period, [&](const py::object& answer) -> std::optional<FingerForces> {
        if (answer.is_none()) return std::nullopt;
        return forces_of(answer, period.model.fingers());
      });
    };
  }
  if (!torques.is_none()) {
    own.torques = [law = shared(std::move(torques))](ControlPeriod& period) {
      return ask(law, period, [&](const py::object& answer) -> JointVector {
        return vector(answer, std::ssize(period.model.scene.hand.joints), "what the law 'torques' returned");
      });
    };
  }
  if (!muscles.is_none()) {
    own.muscles = [law = shared(std::move(muscles))](ControlPeriod& period) {
      return ask(law, period, [&](const py::object& answer) -> Eigen::VectorXd {
        return vector(answer, std::ssize(period.model.scene.hand.muscles), "what the law 'muscles' returned");
      });
    };
  }
  return own;
}

void bind_laws(py::module_& module) {
  PeriodClass type(module, "Period", R"(One control period, as a law of the controller sees it.

All arrays are copies, in SI units, world axes = hand frame. It is over when the law returns. Joints, object and forces
are those of time_s, which is control.feedback_delay before now_s; touch is fingertips.touch.delay old.
What comes before in the chain wrench -> forces -> torques -> muscle forces is found when it is asked for: by the law
given for it, or as published.)");
  bind_state(type);
  bind_contacts(type);
  bind_loads(type);
  bind_desired(type);
  bind_published(type);
  bind_touch(type);
}

}  // namespace thenar::python
