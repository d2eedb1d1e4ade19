// SPDX-License-Identifier: Apache-2.0
#include "engine/models/surface_model.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "collision/fine_parts.h"
#include "engine/finder/settle.h"
#include "engine/grasp/edge_contacts.h"
#include "engine/pulps/pulp_levels.h"
#include "engine/scenes/config.h"
#include "engine/scenes/object_bounds.h"
#include "engine/scenes/scene_file.h"

namespace thenar {

using Eigen::Index;
using Eigen::Vector3d;

namespace {

/// Refuses places that a scene names in its object and that are not within its surface. The origin, which is where all
/// of them are unless named, may lie anywhere.
void check_places(const Model& model) {
  const Scene& scene = model.scene;
  const Eigen::AlignedBox3d& box = model.object.bounds();
  const auto check = [&](const Vector3d& point_m, const char* key) {
    // Samples end up to a support before the surface does.
    if (point_m.isZero(0.0) || box.exteriorDistance(point_m) <= model.object.support_m()) return;
    throw ConfigError({{scene.name, key, "must lie within the object: " + in_words(box) + " in its frame"}});
  };
  check(scene.object.centre_of_mass_m, "object.centre_of_mass");
  if (scene.task.push) check(scene.task.push->at_m, "task.push.at");
}

void make_room_for_contacts(Model& model) {
  model.max_contacts = model.fingers() * std::min(model.scene.contact.max_per_finger, model.pulps.front().controls());
}

/// What depends on how many control points the pulps have.
void fit_to_controls(Model& model) {
  make_room_for_contacts(model);
  double spacing_m = 0.0;  // of control points
  for (const Pulp& pulp : model.pulps) spacing_m = std::max(spacing_m, std::sqrt(pulp.area_m2.mean()));
  find_edges(model);
  std::vector<Index> fine = fine_parts(model.object.cloud(), spacing_m);
  const auto edges =
      std::partition(fine.begin(), fine.end(), [&](Index sample) { return !has_edges_for_cells(model, sample); });
  const auto places_m = [&](auto begin, auto end) {
    return Eigen::Matrix3Xd(model.object.cloud().points_m(Eigen::all, std::vector<Index>(begin, end)));
  };
  model.fine_m = places_m(fine.begin(), edges);
  model.fine_edges_m = places_m(edges, fine.end());
}

/// Whether a model on the same surface has the fingertips that this one would get: then the surface has their edges. A
/// level that is chosen depends on more than these.
bool has_same_fingertips(const Model& model, const Model& known) {
  const std::optional<int>& level = model.scene.contact.level;
  return level && *level == known.level && have_same_pulps(model.scene, known.scene);
}

void make_fingertips(Model& model, Model* known) {
  const Scene& scene = model.scene;
  model.max_contacts = model.fingers();
  if (!scene.fingertips) return;
  if (known != nullptr && has_same_fingertips(model, *known)) {
    model.pulps = std::move(known->pulps);
    model.level = known->level;
    model.fine_m = std::move(known->fine_m);
    model.fine_edges_m = std::move(known->fine_edges_m);
    make_room_for_contacts(model);
    return;
  }
  model.pulps = make_pulps(scene);
  if (scene.contact.level != 0) {
    model.level = scene.contact.level
                      ? *scene.contact.level
                      : choose_level(estimate_levels(scene, model.pulps), scene.contact.force_error).level;
    for (Pulp& pulp : model.pulps) set_level(pulp, model.level);
  }
  fit_to_controls(model);
}

}  // namespace

Model surface_model(Scene scene, ImplicitSurface surface, Model* known) {
  Model model{.scene = std::move(scene), .object_notes = {}, .object = std::move(surface)};
  model.exact = exact_shape_of(model.scene.object.shape);
  check_places(model);
  make_fingertips(model, known);
  if (model.scene.settles) settle(model);
  return model;
}

void set_fingertips(Model& model, PulpKernel kernel, int level) {
  model.scene.fingertips->material.kernel = kernel;
  model.level = level;
  for (Pulp& pulp : model.pulps) {
    pulp.material.kernel = kernel;
    set_level(pulp, level);
  }
  fit_to_controls(model);
}

}  // namespace thenar
