// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "engine/grasp/model.h"
#include "engine/models/object_surface.h"
#include "engine/studies/model_parts.h"

namespace thenar {

/// Callbacks while a model is loaded.
struct ModelWatch {
  StartWatch begins = {};  ///< See build_model().
  /// Called with the whole model, before `model: auto` runs it to find the needed parts: it may throw to end this, and
  /// change the control period.
  std::function<void(Model&)> is_whole = {};
};

/// Loads a scene's model: build_model() and, for `model: auto`, as_needed(). Every program runs this one; only
/// comparisons of models with and without parts build them directly. Throws ConfigError or FileError.
[[nodiscard]] Model load_model(Scene scene, const ModelWatch& watch = {});

/// Loads the model of a scene file with changes, as after --set.
[[nodiscard]] Model load_model(const std::filesystem::path& scene, const std::vector<std::string>& changes = {},
                               const ModelWatch& watch = {});

/// Loads a scene's model faster, with parts of a known model that the scene shares, as build_model() does.
[[nodiscard]] Model load_model(Scene scene, Model known);

/// Throws ConfigError if the model does not have the part, as `model: auto` left it out: for studies of that part.
void require_part(const Model& model, Part part, const std::filesystem::path& scene);

}  // namespace thenar
