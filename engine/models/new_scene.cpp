// SPDX-License-Identifier: Apache-2.0
#include "engine/models/new_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <system_error>

#include "engine/formats/files.h"
#include "engine/formats/point_cloud_file.h"
#include "engine/formats/text.h"
#include "engine/models/object_surface.h"
#include "engine/pulps/pressed_pulp.h"
#include "engine/pulps/pulp_levels.h"
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

namespace {

/// Gives the fingertips what their loads need, so that a run has nothing to warn of: room for all contacts that bear
/// load, and where a patch would be wider than a half space stands for, a modulus that grows with the load as that of
/// people's pulps does.
void fit_fingertips(Scene& scene) {
  constexpr double kWidest = 0.45;           // Of the half of a pulp's radius that a run warns of.
  constexpr double kStiffening_per_N = 0.5;  // Of a human fingertip.
  constexpr double kSpare = 1.25;            // For loads that change, and objects that are hollow there.
  Scene loaded = scene;
  // The finger that faces all others bears as much as they do: 2 (n - 1) / n of lambda.
  const double n = scene.hand.fingers();
  double& lambda_N = loaded.control->internal_force_N;
  if (scene.grasp->press_N) lambda_N = 0.5 * n * *scene.grasp->press_N;
  lambda_N *= 2.0 * (n - 1.0) / n;
  std::vector<Pulp> pulps = make_pulps(loaded);
  const auto is_wide = [&](const Pulp& pulp) {
    const auto k = static_cast<std::size_t>(&pulp - pulps.data());
    const double radius_m = hertz_radius_m(pulp, expected_load_N(loaded, pulp));
    return share_factor(pulp, scene.hand.fingertips[k].normal) * radius_m > kWidest * pulp.radius_m;
  };
  if (std::ranges::any_of(pulps, is_wide)) {
    scene.fingertips->material.stiffening_per_N = loaded.fingertips->material.stiffening_per_N = kStiffening_per_N;
    pulps = make_pulps(loaded);
  }
  const double needed = kSpare * static_cast<double>(estimate_level(loaded, pulps, 0).needed);
  scene.contact.max_per_finger = std::max(scene.contact.max_per_finger, static_cast<Eigen::Index>(std::ceil(needed)));
}

/// The volume that the object's mesh encloses, and how dense its mass makes it; nothing for other surfaces.
std::string mass_in_words(const ObjectSettings& object, const EnclosedSolid& solid) {
  if (!(solid.volume_m3 > 0.0)) return "";
  return fmt::format(
      " It encloses {:.4g} cm^3, so that its mass of {:.4g} g makes it {:.3g} g/cm^3 dense; its weight acts at their "
      "centroid, which object.centre_of_mass names. It has no inertia here.",
      1e6 * solid.volume_m3, 1e3 * object.mass_kg, 1e-3 * object.mass_kg / solid.volume_m3);
}

}  // namespace

Scene scene_of_object(const ObjectWish& wish) {
  expect_object(wish.object);
  Scene scene = scene_to_begin_with(load_hand(find_hand(wish.hand.string())), {wish.object, wish.unit_m}, wish.mass_kg,
                                    wish.friction);
  if (!is_mesh_file(wish.object)) scene.object.points = 0;
  if (wish.press_N) scene.grasp->press_N = *wish.press_N;
  fit_fingertips(scene);
  return scene;
}

NewScene write_new_scene(const fs::path& file, const ObjectWish& wish) {
  if (fs::exists(file)) throw FileError(file, "is there already, and is not replaced");
  Scene scene = scene_of_object(wish);
  NewScene made;
  const ImplicitSurface surface = make_object_surface(scene, made.notes);
  made.size_m = surface.bounds().sizes();
  const EnclosedSolid solid = object_solid(scene, surface, made.notes);
  scene.object.centre_of_mass_m = solid.centroid_m;
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
      "the file measures. In the file's axes, which are the object's, it reaches over x, y, z = {}.{}",
      size_mm.x(), size_mm.y(), size_mm.z(), in_words(surface.bounds()), mass_in_words(scene.object, solid));
  write_file(file, scene_text(scene, notes));
  return made;
}

}  // namespace thenar
