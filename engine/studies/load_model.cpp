#include "engine/studies/load_model.h"

#include <utility>

#include "engine/scenes/build_model.h"
#include "engine/scenes/scene_file.h"
#include "engine/studies/model_parts.h"

namespace thenar {

Model load_model(Scene scene, const ModelWatch& watch) {
  Model model = build_model(std::move(scene), watch.begins);
  if (watch.is_whole) watch.is_whole(model);
  return as_needed(std::move(model));
}

Model load_model(const std::filesystem::path& scene, const std::vector<std::string>& changes, const ModelWatch& watch) {
  return load_model(load_scene(scene, changes), watch);
}

Model load_model(Scene scene, const Model& known) { return as_needed(build_model(std::move(scene), known)); }

}  // namespace thenar
