// SPDX-License-Identifier: Apache-2.0
#include "engine/models/scene_environment.h"

#include <fmt/format.h>

#include <optional>
#include <vector>

#include "engine/environment/room_for.h"
#include "engine/scenes/config.h"

namespace thenar {

using Eigen::Vector3d;

void check_room(const Scene& scene, const std::shared_ptr<const SampledSolid>& sampled) {
  if (!scene.environment) return;
  const std::optional<Solid> exact = solid_of(scene.object.shape);
  const TouchingSolid object = exact ? TouchingSolid(*exact) : TouchingSolid(sampled);
  const auto overlap = find_overlap(*scene.environment, object, scene.object.X_WO);
  if (!overlap) return;
  const auto at = [&](const Overlap::Place& place) {
    const Vector3d p_mm = 1e3 * place.p_E;
    return fmt::format("'{}' at ({:.3g}, {:.3g}, {:.3g}) mm of its frame", scene.environment->bodies[place.body].name,
                       p_mm.x(), p_mm.y(), p_mm.z());
  };
  const std::string fault =
      overlap->against
          ? fmt::format(
                "the object does not fit: {} and {} press against one another by {:.3g} mm, and no motion of it "
                "opens both",
                at(overlap->deepest), at(*overlap->against), 1e3 * overlap->depth_m)
          : fmt::format("the object lies {:.3g} mm deep in {}: move one of them", 1e3 * overlap->depth_m,
                        at(overlap->deepest));
  throw ConfigError({{scene.environment->place, fmt::format("environment.bodies[{}]", overlap->deepest.body), fault}});
}

}  // namespace thenar
