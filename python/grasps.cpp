// SPDX-License-Identifier: Apache-2.0
#include "python/grasps.h"

#include <fmt/format.h>
#include <pybind11/stl.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/models/object_surface.h"
#include "engine/models/scene_grasp.h"
#include "python/arrays.h"
#include "python/interpreter.h"
#include "python/scene.h"

namespace thenar::python {

namespace {

/// A grasp that was found for a scene.
struct Found : Constructed {
  Found(std::shared_ptr<const SceneHandle> of, FoundGrasp found) : scene(std::move(of)), grasp(std::move(found)) {}

  std::shared_ptr<const SceneHandle> scene;
  FoundGrasp grasp;
};

using FoundClass = py::class_<Found, std::shared_ptr<Found>>;

py::list find(const std::shared_ptr<const SceneHandle>& scene, int best, const py::object& seed) {
  if (best < 1 || best > 20) throw py::value_error("best must lie within 1 .. 20");
  Scene wanted = scene->scene();
  if (scene->grasp()) throw py::value_error("this scene is of a found grasp already");
  if (!wanted.grasp) wanted.grasp = GraspWish{};
  if (!seed.is_none()) wanted.grasp->seed = static_cast<std::uint32_t>(whole_number(seed, "seed", 0, 0xFFFFFFFF));
  FinderReport report;
  SignalWatch watch;
  {
    const Unlocked others;
    std::vector<std::string> notes;
    const ImplicitSurface surface = make_object_surface(wanted, notes);
    report = find_tried_grasps(wanted, surface, {.seed = wanted.grasp->seed, .best = best},
                               [&](double, int) { return !watch(); });
  }
  watch.rethrow();
  if (report.grasps.empty()) {
    const py::object error = py::module_::import("thenar.errors").attr("NoGrasp");
    const std::string reason = in_words(report.refusal.value_or(Refusal{"none was found", ""}));
    PyErr_SetObject(error.ptr(), py::str(reason).ptr());
    throw py::error_already_set();
  }
  py::list grasps;
  for (const FoundGrasp& grasp : report.grasps) grasps.append(std::make_shared<Found>(scene, grasp));
  return grasps;
}

std::vector<std::string> finger_names(const Found& found) {
  std::vector<std::string> names;
  for (const int k : found.grasp.fingers) names.push_back(found.scene->scene().hand.fingertips[k].finger);
  return names;
}

Array places(const Found& found, Eigen::Vector3d FingerPlace::*field) {
  Eigen::Matrix3Xd rows(3, static_cast<Eigen::Index>(found.grasp.places.size()));
  for (Eigen::Index k = 0; k < rows.cols(); ++k) rows.col(k) = found.grasp.places[k].*field;
  return copy(rows.transpose());
}

/// A property for each measure.
void bind_measures(FoundClass& type) {
  for (const GraspMeasure& measure : grasp_measures()) {
    const std::string unit = measure.unit.empty() ? "" : fmt::format(" [{}]", measure.unit);
    type.def_property_readonly(
        std::string(measure.name).c_str(), [&measure](const Found& f) { return measure.value(f.grasp); },
        fmt::format("{}{}", measure.sentence, unit).c_str());
  }
}

}  // namespace

void bind_grasps(py::module_& module) {
  module.def(
      "grasp", &find, py::arg("scene"), py::kw_only(), py::arg("best") = 1, py::arg("seed") = py::none(),
      R"(Finds how the scene's hand can hold its object: `best` grasps, the best first; each was tried in the engine.

What the scene asks of the grasp under `grasp` is heeded. Raises NoGrasp with the reason where there is none.)");
  FoundClass type(module, "Grasp", "A grasp that was found.");
  bind_measures(type);
  type.def_property_readonly("fingers", &finger_names, "Names of those that hold.")
      .def_property_readonly(
          "q_rad", [](const Found& f) { return copy(f.grasp.q); }, "(joints,) Of these fingers.")
      .def_property_readonly(
          "object", [](const Found& f) { return copy(f.grasp.X_WO.matrix()); }, "(4, 4) Pose of the object.")
      .def_property_readonly(
          "points_m", [](const Found& f) { return places(f, &FingerPlace::point_O); },
          "(fingers, 3) Where they touch, object frame.")
      .def_property_readonly(
          "normals", [](const Found& f) { return places(f, &FingerPlace::normal_O); },
          "(fingers, 3) Outward there, object frame.")
      .def_property_readonly(
          "force_N", [](const Found& f) { return places(f, &FingerPlace::force_W); },
          "(fingers, 3) On the object against its weight, world axes.")
      .def(
          "scene",
          [](const Found& f) {
            const Unlocked others;
            return std::make_shared<SceneHandle>(f.scene->file(), f.scene->changes(), f.grasp);
          },
          "The scene with this grasp, ready to run.")
      .def("__str__", [](const Found& f) { return in_words(f.grasp, f.scene->scene().hand); })
      .def("__repr__", [](const Found& f) {
        std::string names;
        for (const std::string& name : finger_names(f)) names += (names.empty() ? "" : ", ") + name;
        return fmt::format("<thenar.Grasp by {}, margin {:.2f}>", names, f.grasp.margin);
      });
}

}  // namespace thenar::python
