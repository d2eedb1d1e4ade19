#include "engine/scenes/build_model.h"

#include <string>
#include <utility>
#include <vector>

#include "engine/scenes/scene_environment.h"
#include "engine/scenes/scene_grasp.h"
#include "engine/scenes/surface_model.h"

namespace thenar {

namespace {

Model with_surface(Scene scene, std::vector<std::string> notes, ImplicitSurface surface) {
  std::string grasp_notes;
  if (scene.grasp) grasp_notes = find_scene_grasp(scene, surface);
  check_room(scene);
  Model model = surface_model(std::move(scene), std::move(surface));
  model.object_notes = std::move(notes);
  model.grasp_notes = std::move(grasp_notes);
  return model;
}

}  // namespace

Model build_model(Scene scene, const StartWatch& begins) {
  std::vector<std::string> notes;
  ImplicitSurface surface = make_object_surface(scene, notes, begins);
  if (begins && scene.fingertips) begins("the fingertips");
  return with_surface(std::move(scene), std::move(notes), std::move(surface));
}

Model build_model(Scene scene, const Model& known) {
  if (!have_same_surface(scene, known.scene)) return build_model(std::move(scene));
  return with_surface(std::move(scene), known.object_notes, known.object);
}

}  // namespace thenar
