// SPDX-License-Identifier: Apache-2.0
#include "engine/studies/known_models.h"

#include <algorithm>
#include <utility>

#include "engine/models/object_surface.h"
#include "engine/studies/load_model.h"

namespace thenar {

bool KnownModels::Known::has_surface_of(const Scene& scene, std::size_t hash) const {
  return file_hash == hash && have_same_surface(asked, scene);
}

std::shared_ptr<const Model> KnownModels::like(const Scene& scene, std::size_t file_hash) {
  const std::lock_guard lock(mutex_);
  const auto found =
      std::ranges::find_if(known_, [&](const Known& known) { return known.has_surface_of(scene, file_hash); });
  return found == known_.end() ? nullptr : found->model;
}

void KnownModels::keep(Known made) {
  std::deque<Known> gone;  // A model takes its time to be destroyed.
  const std::lock_guard lock(mutex_);
  known_.push_front(std::move(made));
  Eigen::Index samples = 0;
  std::deque<Known> kept;
  for (Known& known : known_) {
    const bool is_newest = kept.empty();
    const bool is_again = !is_newest && known.has_surface_of(kept.front().asked, kept.front().file_hash);
    samples += is_again ? 0 : known.model->object.cloud().points_m.cols();
    const bool has_room = is_newest || (kept.size() < kMostModels && samples <= kMostSamples);
    (!is_again && has_room ? kept : gone).push_back(std::move(known));
  }
  known_ = std::move(kept);
}

std::shared_ptr<const Model> KnownModels::load(const Scene& scene) {
  const std::size_t hash = object_file_hash(scene);
  const std::shared_ptr<const Model> known = like(scene, hash);
  auto model = std::make_shared<const Model>(known ? load_model(scene, *known) : load_model(scene));
  keep({scene, hash, model});
  return model;
}

}  // namespace thenar
