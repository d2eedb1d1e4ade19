// SPDX-License-Identifier: Apache-2.0
#include "engine/scenes/scene_file.h"

#include <fmt/format.h>

#include <numbers>
#include <optional>
#include <utility>

#include "engine/formats/files.h"
#include "engine/formats/text.h"
#include "engine/scenes/config.h"
#include "engine/scenes/config_reader.h"
#include "engine/scenes/describe.h"
#include "engine/scenes/hand_file.h"
#include "engine/scenes/key_table.h"

namespace thenar {

std::string in_words(const Tolerance& tolerance) {
  return fmt::format("{{position: {:.3g} mm, rotation: {:.3g} deg, force: {:.3g} %, moment: {:.3g} %, margin: {:.3g}}}",
                     1e3 * tolerance.position_m, tolerance.rotation_rad * 180.0 / std::numbers::pi,
                     100.0 * tolerance.force, 100.0 * tolerance.moment, tolerance.margin);
}

namespace {

/// What a file is by its name, where that is no scene; empty: it may be one.
std::string other_kind(const std::filesystem::path& file) {
  const std::string ending = ending_of(file);
  for (const std::string_view of : {".obj", ".stl", ".off", ".ply", ".glb", ".gltf", ".xyz", ".pcd"}) {
    if (ending == of) return "is an object, and no scene: thenar new my.yaml --object " + file.string() + " writes one";
  }
  if (ending == ".xml" || ending == ".urdf") return "is a hand for `thenar hand import`, and no scene";
  return ending == ".mcap" ? "is a recording, and no scene: `thenar demo` shows it" : "";
}

}  // namespace

Scene load_scene(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
  if (is_hand_file(file)) {
    throw ConfigError({{printable(file.string()), "", "is a hand, which a scene names in hand.model, and no scene"}});
  }
  if (const std::string other = other_kind(file); !other.empty())
    throw ConfigError({{printable(file.string()), "", other}});
  Config config(file, scene_keys(), overrides);
  const ConfigMap root = config.root();
  SceneFile read;
  read_config(root, [&](Visitor& v) { describe(v, read); });
  try {
    config.finish();
  } catch (const ConfigError& error) {
    // A file may be there the next time: where that is all that is wrong, the scene is not.
    if (read.is_readable || error.diagnostics().size() > 1) throw;
    const std::string& place = error.diagnostics().front().location;
    throw ReadError(place, std::string(error.what()).substr(place.size() + 2));
  }
  Scene& scene = read.scene;
  scene.defaults_used = config.defaults_used();
  if (scene.only_needed && !root.has("tolerance")) {
    scene.defaults_used.push_back("tolerance: " + in_words(scene.tolerance));
  }
  return std::move(scene);
}

std::vector<std::filesystem::path> scene_files(const std::filesystem::path& scene,
                                               const std::vector<std::string>& overrides) {
  std::vector<std::filesystem::path> files{scene};
  const auto add = [&files](const std::filesystem::path& file) {
    if (!file.empty()) files.push_back(file);
  };
  const Config config(scene, scene_keys(), overrides);
  const ConfigMap root = config.root();
  if (root.is_map("hand") && !root.map("hand").has("slides")) add(found_hand(root.map("hand").path("model")));
  if (root.is_map("object") && root.map("object").is_map("shape")) {
    const ConfigMap shape = root.map("object").map("shape");
    if (shape.has("cloud")) add(shape.is_map("cloud") ? shape.map("cloud").path("file") : shape.path("cloud"));
  }
  if (root.is_map("control") && root.map("control").has("drive")) add(root.map("control").path("drive"));
  if (root.is_map("grasp") && root.map("grasp").has("from")) add(root.map("grasp").path("from"));
  return files;
}

}  // namespace thenar
