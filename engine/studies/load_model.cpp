// SPDX-License-Identifier: Apache-2.0
#include "engine/studies/load_model.h"

#include <string>
#include <utility>

#include "engine/models/build_model.h"
#include "engine/scenes/config.h"
#include "engine/scenes/scene_file.h"

namespace thenar {

Model load_model(Scene scene, const ModelWatch& watch) {
  Model model = build_model(std::move(scene), watch.begins);
  if (watch.is_whole) watch.is_whole(model);
  return as_needed(std::move(model));
}

Model load_model(const std::filesystem::path& scene, const std::vector<std::string>& changes, const ModelWatch& watch) {
  return load_model(load_scene(scene, changes), watch);
}

Model load_model(Scene scene, Model known) { return as_needed(build_model(std::move(scene), std::move(known))); }

void require_part(const Model& model, Part part, const std::filesystem::path& scene) {
  if (has(model.scene, part)) return;
  throw ConfigError({{scene.string(), "model",
                      std::string("auto leaves out what this is about, the ") + to_string(part) +
                          ": name full, or a smaller tolerance"}});
}

}  // namespace thenar
