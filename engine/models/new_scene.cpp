// SPDX-License-Identifier: Apache-2.0
#include "engine/models/new_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <system_error>

#include "engine/formats/files.h"
#include "engine/formats/point_cloud_file.h"
#include "engine/formats/text.h"
#include "engine/models/object_surface.h"
#include "engine/scenes/hand_file.h"
#include "engine/scenes/object_bounds.h"
#include "engine/scenes/scene_file.h"
#include "engine/scenes/scene_text.h"
#include "engine/scenes/shared_data.h"

namespace thenar {

namespace fs = std::filesystem;

namespace {

/// Throws FileError for a name that no text can have, and where there is no such file: then it names the surface in its
/// folder whose name is nearest.
void expect_object(const fs::path& object) {
  std::error_code none;
  if (first_unprintable(object.string()) != std::string::npos) {
    throw FileError(object, "a scene cannot name a file with such bytes in its name: rename it");
  }
  if (fs::exists(object, none)) return;
  if (fs::is_symlink(object, none)) throw FileError(object, "is a link to no file");
  const fs::path folder = object.parent_path();
  std::vector<std::string> names;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder.empty() ? "." : folder, none)) {
    if (is_surface_file(entry.path())) names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  const std::vector<std::string_view> candidates(names.begin(), names.end());
  const std::string_view nearest = nearest_word(object.filename().string(), candidates);
  throw FileError(object, "no such file" + did_you_mean(nearest.empty() ? "" : (folder / nearest).string()));
}

}  // namespace

fs::path schema_file() {
  const fs::path file = shared_data() / "docs" / "reference" / "scene.schema.json";
  std::error_code none;
  return fs::exists(file, none) && file.string().find(' ') == std::string::npos ? file : fs::path();
}

Scene scene_of_object(const ObjectWish& wish) {
  expect_object(wish.object);
  Scene scene = scene_to_begin_with(load_hand(find_hand(wish.hand.string())), {wish.object, wish.unit_m}, wish.mass_kg,
                                    wish.friction);
  if (!is_mesh_file(wish.object)) scene.object.points = 0;
  if (wish.press_N) scene.grasp->press_N = *wish.press_N;
  return scene;
}

NewScene write_new_scene(const fs::path& file, const ObjectWish& wish) {
  if (fs::exists(file)) throw FileError(file, "is there already, and is not replaced");
  Scene scene = scene_of_object(wish);
  NewScene made;
  const ImplicitSurface surface = make_object_surface(scene, made.notes);
  made.size_m = surface.bounds().sizes();
  scene.object.centre_of_mass_m = object_centroid_m(scene, surface, made.notes);
  SceneTextNotes notes;
  notes.schema = schema_file();
  const fs::path hand = find_hand(wish.hand.string());
  notes.hand = hand_in_scene(hand, seen_from(file.parent_path(), hand));
  notes.object = seen_from(file.parent_path(), wish.object);
  notes.about =
      scene.name +
      ", held by a hand: written by thenar new. thenar check says what is modelled, thenar run runs it, thenar "
      "keys lists all that a scene may say.";
  const Eigen::Vector3d size_mm = 1e3 * made.size_m;
  notes.grasp = fmt::format(
      "The object measures {:.1f} x {:.1f} x {:.1f} mm. If that is not so, change object.shape.cloud.unit: what 1 in "
      "the file measures. In the file's axes, which are the object's, it reaches over x, y, z = {}.",
      size_mm.x(), size_mm.y(), size_mm.z(), in_words(surface.bounds()));
  write_file(file, scene_text(scene, notes));
  return made;
}

}  // namespace thenar
