// SPDX-License-Identifier: Apache-2.0
#include "python/scene.h"

#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <cctype>
#include <utility>

#include "engine/models/new_scene.h"
#include "engine/models/scene_grasp.h"
#include "engine/scenes/scene_file.h"
#include "engine/scenes/shared_data.h"
#include "engine/scenes/units.h"
#include "engine/studies/known_models.h"
#include "python/arrays.h"

namespace thenar::python {

namespace {

Scene load(const std::filesystem::path& file, const std::vector<std::string>& changes,
           const std::optional<FoundGrasp>& grasp) {
  Scene scene = load_scene(file, changes);
  if (grasp) take_grasp(*grasp, scene);
  return scene;
}

/// A value of Python as YAML, bounded: lists may contain themselves, or one another many times.
class ValueText {
 public:
  explicit ValueText(std::string key) : key_(std::move(key)) {}

  [[nodiscard]] std::string of(py::handle value) {
    add(value, 0);
    return std::move(text_);
  }

 private:
  void add(py::handle value, int depth);
  void add_items(py::handle items, int depth);
  void add_scalar(const std::string& text);

  std::string key_, text_;
};

/// Words that YAML would take for something else are quoted.
void ValueText::add_scalar(const std::string& text) {
  if (text.find_first_of("\n\r") != std::string::npos) throw py::value_error("a value of a scene is one line");
  const bool plain = !text.empty() && text.find_first_of(":#{}[],&*!|>'\"%@`") == std::string::npos &&
                     text.front() != ' ' && text.back() != ' ';
  if (plain) {
    text_ += text;
    return;
  }
  text_ += '\'';
  for (const char c : text) text_ += c == '\'' ? std::string("''") : std::string(1, c);
  text_ += '\'';
}

void ValueText::add_items(py::handle items, int depth) {
  text_ += '[';
  bool first = true;
  for (const py::handle item : items) {
    if (!std::exchange(first, false)) text_ += ", ";
    add(item, depth + 1);
  }
  text_ += ']';
}

void ValueText::add(py::handle value, int depth) {
  constexpr int kMostDepth = 32;
  constexpr std::size_t kMostBytes = 16'000'000;
  if (depth > kMostDepth) {
    throw py::value_error(fmt::format("{} is nested more than {} deep: does it contain itself?", key_, kMostDepth));
  }
  if (text_.size() > kMostBytes) throw py::value_error(fmt::format("{} is longer than {} bytes", key_, kMostBytes));
  if (py::isinstance<py::bool_>(value)) {
    text_ += value.cast<bool>() ? "true" : "false";
  } else if (py::isinstance<py::str>(value)) {
    add_scalar(text_of(value, key_));
  } else if (py::hasattr(value, "__fspath__")) {
    add_scalar(text_of(py::str(value.attr("__fspath__")()), key_));
  } else if (py::isinstance<py::dict>(value)) {
    text_ += '{';
    bool first = true;
    for (const auto& [name, item] : value.cast<py::dict>()) {
      if (!std::exchange(first, false)) text_ += ", ";
      text_ += text_of(py::str(name), "a name in " + key_) + ": ";
      add(item, depth + 1);
    }
    text_ += '}';
  } else if (py::hasattr(value, "tolist")) {
    add(value.attr("tolist")(), depth + 1);
  } else if (py::isinstance<py::list>(value) || py::isinstance<py::tuple>(value)) {
    add_items(value, depth);
  } else if (py::isinstance<py::int_>(value)) {
    text_ += text_of(py::str(value), key_);
  } else if (py::isinstance<py::float_>(value)) {
    text_ += fmt::format("{}", number(value, key_));
  } else {
    throw py::type_error(key_ +
                         " takes text, such as '150 g', a number, a list or a dict, as a scene file would have it");
  }
}

std::vector<std::string> joined(std::vector<std::string> changes, const py::dict& more) {
  for (const auto& [key, value] : more) {
    if (!py::isinstance<py::str>(key)) throw py::type_error("keys of a scene are text, such as 'object.mass'");
    const std::string name = text_of(key, "a key of a scene");
    changes.push_back(name + "=" + yaml_text(value, name));
  }
  return changes;
}

template <typename Named>
std::vector<std::string> names_of(const std::vector<Named>& all) {
  std::vector<std::string> names;
  for (const Named& one : all) {
    if constexpr (requires { one.finger; }) {
      names.push_back(one.finger);
    } else {
      names.push_back(one.name);
    }
  }
  return names;
}

std::shared_ptr<SceneHandle> make(const std::filesystem::path& file, std::vector<std::string> changes,
                                  std::optional<FoundGrasp> grasp = {}) {
  const Unlocked others;
  return std::make_shared<SceneHandle>(file, std::move(changes), std::move(grasp));
}

KnownModels& known_models() {
  static KnownModels models;
  return models;
}

}  // namespace

SceneHandle::SceneHandle(std::filesystem::path file, std::vector<std::string> changes, std::optional<FoundGrasp> grasp)
    : file_(std::move(file)),
      changes_(std::move(changes)),
      grasp_(std::move(grasp)),
      scene_(load(file_, changes_, grasp_)) {}

std::shared_ptr<const Model> SceneHandle::model() const {
  const std::lock_guard lock(making_);
  if (!model_) model_ = known_models().load(scene_);
  return model_;
}

std::shared_ptr<const Model> model_of(const SceneHandle& scene) {
  const Unlocked others;
  return scene.model();
}

std::string yaml_text(py::handle value, const std::string& key) {
  // A text alone is YAML already, as after --set.
  return py::isinstance<py::str>(value) ? text_of(value, key) : ValueText(key).of(value);
}

double quantity_of(py::handle value, Dimension dimension, const std::string& name) {
  if (!py::isinstance<py::str>(value)) {
    throw py::type_error(
        fmt::format("{} takes text with a unit, such as '1 {}'", name, unit_symbols(dimension).front()));
  }
  const Quantity read = read_quantity(text_of(value, name), dimension);
  if (!read.fault.empty()) throw py::value_error(fmt::format("{}: {}", name, read.fault));
  return read.value;
}

double time_of(py::handle value, const std::string& name) {
  return py::isinstance<py::str>(value) ? quantity_of(value, Dimension::kTime, name) : number(value, name);
}

namespace {

using SceneClass = py::class_<SceneHandle, std::shared_ptr<SceneHandle>>;

std::shared_ptr<SceneHandle> new_scene(const std::filesystem::path& file, const std::filesystem::path& object,
                                       const std::filesystem::path& hand, const py::object& unit,
                                       const py::object& mass, py::handle friction) {
  ObjectWish wish{.object = object, .hand = hand};
  // As after --unit: "mm" is one.
  const bool bare = py::isinstance<py::str>(unit) && py::len(unit) > 0 &&
                    std::isalpha(static_cast<unsigned char>(text_of(unit, "unit").front())) != 0;
  wish.unit_m = quantity_of(bare ? py::str("1 ") + unit : py::object(unit), Dimension::kLength, "unit");
  wish.mass_kg = quantity_of(mass, Dimension::kMass, "mass");
  wish.friction = number(friction, "friction");
  if (!(wish.unit_m > 0.0)) throw py::value_error("unit must be greater than zero");
  if (!(wish.mass_kg > 0.0)) throw py::value_error("mass must be greater than zero");
  if (!(wish.friction >= 0.0 && wish.friction <= 10.0)) throw py::value_error("friction must lie within 0 .. 10");
  {
    const Unlocked others;
    (void)write_new_scene(file, wish);
  }
  return make(file, {});
}

/// Functions of scenes and hands that come with the package, and of new scenes.
void bind_scene_files(py::module_& module) {
  module.def(
      "use_data", [](const std::filesystem::path& folder) { use_shared_data(folder); }, py::arg("folder"),
      "Where scenes and hands that come with the package lie.");
  module.def(
      "scenes",
      [] {
        py::dict all;
        for (const KnownScene& scene : known_scenes()) all[py::str(scene.name)] = scene.about;
        return all;
      },
      "Scenes that come with the package, by name, and what each shows.");
  module.def("new_scene", &new_scene, py::arg("file"), py::arg("object"), py::arg("hand") = "hand", py::kw_only(),
             py::arg("unit") = "1 m", py::arg("mass") = "100 g", py::arg("friction") = 0.6,
             R"(Writes a scene in which a hand is to grasp an object of one's own, as `thenar new`.

file: the scene, which is not there yet. object: a mesh (STL, OBJ, OFF, PLY) or a cloud (PLY, PCD, XYZ); unit: what 1
in it measures, '1 mm'. hand: a file, or the name of one that comes with the package (thenar.hands()). mass: '100 g'.
Returns the scene; its grasp is found when it first runs.)");
  module.def("hands", &known_hands, "Names of the hands that come with the package.");
}

/// The constructor, set() and prepare().
void bind_making(SceneClass& type) {
  type.def(py::init([](const std::filesystem::path& file, const py::object& changes) {
             std::vector<std::string> all;
             if (!changes.is_none()) all = joined({}, changes.cast<py::dict>());
             return make(find_scene(file.string()), std::move(all));
           }),
           py::arg("file"), py::arg("set") = py::none(), R"(Reads a scene.

file: a YAML file, or the name of a scene that comes with the package (thenar.scenes()).
set: changes, as set() takes them.
Raises SceneError with every fault, its file, line, column and key; FileError for a file that cannot be read.)")
      .def(
          "set",
          [](const SceneHandle& self, const py::dict& changes) {
            return make(self.file(), joined(self.changes(), changes), self.grasp());
          },
          py::arg("changes"), R"(The scene with some values changed: {'object.mass': '150 g', 'contact.friction': 0.6}.

Keys and units are those of the file; what has a unit is text. Raises as Scene() does.)")
      // What never changes is its own copy. Gymnasium, for one, copies what its environments are made of.
      .def("__copy__", [](const std::shared_ptr<SceneHandle>& self) { return self; })
      .def("__deepcopy__", [](const std::shared_ptr<SceneHandle>& self, const py::dict&) { return self; })
      .def(
          "prepare", [](const SceneHandle& self) { (void)model_of(self); },
          R"(Makes the surfaces now, finds the grasp where the scene asks for one, and, for `model: auto`, which parts
it needs: the first run would do it.)");
}

/// A scene's file, changes and numbers.
void bind_values(SceneClass& type) {
  type.def_property_readonly("file", &SceneHandle::file, "The file it was read from.")
      .def_property_readonly(
          "changes", [](const SceneHandle& self) { return self.changes(); },
          "What set() has changed, as 'key=value', in order.")
      .def_property_readonly("name", [](const SceneHandle& self) { return self.scene().name; })
      .def_property_readonly("duration_s", [](const SceneHandle& self) { return self.scene().duration_s; })
      .def_property_readonly(
          "step_s", [](const SceneHandle& self) { return self.scene().step_s; }, "Of a contact tick.")
      .def_property_readonly("control_period_s", [](const SceneHandle& self) { return self.scene().control_period_s; })
      .def_property_readonly("friction", [](const SceneHandle& self) { return self.scene().contact.friction; })
      .def_property_readonly("mass_kg", [](const SceneHandle& self) { return self.scene().object.mass_kg; });
}

/// The names of the hand's parts, and a scene as text.
void bind_names(SceneClass& type) {
  type.def_property_readonly(
          "fingers", [](const SceneHandle& self) { return names_of(self.scene().hand.fingertips); },
          "Names, in the order of every array that has one row a finger.")
      .def_property_readonly(
          "joints", [](const SceneHandle& self) { return names_of(self.scene().hand.joints); },
          "Names, in the order of q_rad, or of q_m: finger by finger, from the palm on.")
      .def_property_readonly(
          "muscles",
          [](const SceneHandle& self) {
            const Scene& scene = self.scene().only_needed ? model_of(self)->scene : self.scene();
            return scene.has_muscles() ? names_of(scene.hand.muscles) : std::vector<std::string>();
          },
          R"(Names, in the order of muscles_N; empty where torques drive the joints, or `model: auto` needs no muscles.

With `model: auto` it does what prepare() does.)")
      .def("__repr__", [](const SceneHandle& self) {
        return fmt::format("<thenar.Scene '{}'{}>", self.scene().name,
                           self.changes().empty() ? "" : fmt::format(", {} changed", self.changes().size()));
      });
}

}  // namespace

void bind_scene(py::module_& module) {
  bind_scene_files(module);
  SceneClass type(module, "Scene", R"(A scene: what holds what, and how.

Immutable: set() gives another one. It is read and checked when it is made; its surfaces are made when it first runs,
and shared by all runs of it and by other scenes with the same object and fingertips.)");
  bind_making(type);
  bind_values(type);
  bind_names(type);
}

}  // namespace thenar::python
