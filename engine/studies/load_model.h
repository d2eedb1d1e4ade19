#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "engine/grasp/model.h"
#include "engine/scenes/object_surface.h"
#include "engine/studies/model_parts.h"

namespace thenar {

/// Who looks on while a model is made ready.
struct ModelWatch {
  StartWatch begins = {};  ///< As build_model() has it.
  /// Is called with the whole model, before `model: auto` runs it to find what it needs: it may refuse to go on by an
  /// exception, and change the control period.
  std::function<void(Model&)> is_whole = {};
};

/// The model that a scene asks for: build_model() and, for `model: auto`, as_needed(). Every program runs this one;
/// only what compares models with and without their parts builds them itself.
/// Throws ConfigError or FileError where the scene makes no model.
[[nodiscard]] Model load_model(Scene scene, const ModelWatch& watch = {});

/// That of a scene file with changes, as after --set.
[[nodiscard]] Model load_model(const std::filesystem::path& scene, const std::vector<std::string>& changes = {},
                               const ModelWatch& watch = {});

/// The same, sooner: what a known model has that the scene has, too, is taken of it, as build_model() does.
[[nodiscard]] Model load_model(Scene scene, Model known);

/// For what is all about a part. Throws ConfigError where the model does not have it, for `model: auto` left it out.
void require_part(const Model& model, Part part, const std::filesystem::path& scene);

}  // namespace thenar
