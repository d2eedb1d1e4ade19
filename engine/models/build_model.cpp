// SPDX-License-Identifier: Apache-2.0
#include "engine/models/build_model.h"

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "collision/solids/sampled_solid.h"
#include "engine/models/scene_environment.h"
#include "engine/models/scene_grasp.h"
#include "engine/models/surface_model.h"

namespace thenar {

namespace {

/// `sampled`: of this surface, if it has been made.
Model with_surface(Scene scene, std::vector<std::string> notes, ImplicitSurface surface,
                   std::shared_ptr<const SampledSolid> sampled = nullptr, Model* known = nullptr) {
  if (!scene.environment || solid_of(scene.object.shape)) {
    sampled = nullptr;
  } else if (!sampled) {
    sampled = std::make_shared<const SampledSolid>(surface.cloud());
  }
  const TouchingSolid object = touching_object(scene, sampled);
  stand_object(scene, object);
  std::string grasp_notes;
  if (scene.grasp) grasp_notes = find_scene_grasp(scene, surface);
  place_by_object(scene);
  check_room(scene, object, !grasp_notes.empty());
  Model model = surface_model(std::move(scene), std::move(surface), known);
  model.sampled = std::move(sampled);
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

Model build_model(Scene scene, Model known) {
  if (!have_same_surface(scene, known.scene)) return build_model(std::move(scene));
  // A grasp is found on the surface as it was made, and rigid fingertips touch it so.
  const bool lends = scene.fingertips && !scene.grasp;
  if (!lends) known.object.forget_edges();
  return with_surface(std::move(scene), std::move(known.object_notes), std::move(known.object),
                      std::move(known.sampled), lends ? &known : nullptr);
}

}  // namespace thenar
