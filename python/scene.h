// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/pybind11.h>

#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "engine/finder/found_grasp.h"
#include "engine/grasp/model.h"
#include "engine/grasp/scene.h"
#include "engine/scenes/units.h"
#include "python/interpreter.h"

namespace thenar::python {

namespace py = pybind11;

/// A scene's file, the changes to it, and what they make. It never changes; its model is made when it is first needed,
/// and shared by all runs of it. Scenes on the same surface share the making of it: KnownModels.
class SceneHandle : public Constructed {
 public:
  SceneHandle(std::filesystem::path file, std::vector<std::string> changes, std::optional<FoundGrasp> grasp = {});

  [[nodiscard]] const Scene& scene() const { return scene_; }
  [[nodiscard]] const std::filesystem::path& file() const { return file_; }
  [[nodiscard]] const std::vector<std::string>& changes() const { return changes_; }
  [[nodiscard]] const std::optional<FoundGrasp>& grasp() const { return grasp_; }
  /// Returns the model. Called without the interpreter's lock. Throws ConfigError and FileError.
  [[nodiscard]] std::shared_ptr<const Model> model() const;

 private:
  std::filesystem::path file_;
  std::vector<std::string> changes_;
  std::optional<FoundGrasp> grasp_;
  Scene scene_;
  mutable std::mutex making_;
  mutable std::shared_ptr<const Model> model_;
};

/// Returns the scene's model; others may have the interpreter while it is made.
[[nodiscard]] std::shared_ptr<const Model> model_of(const SceneHandle& scene);

/// Returns a value as in a scene file: a quantity as text, `[1 mm, 2 mm]`, `{box: [...]}`. Raises TypeError and
/// ValueError.
[[nodiscard]] std::string yaml_text(py::handle value, const std::string& key);

/// Returns the SI value of text with a unit. Raises.
[[nodiscard]] double quantity_of(py::handle value, Dimension dimension, const std::string& name);

/// Returns a time [s]: from seconds, or text with a unit. Raises.
[[nodiscard]] double time_of(py::handle value, const std::string& name);

void bind_scene(py::module_& module);

}  // namespace thenar::python
