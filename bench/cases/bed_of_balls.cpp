// SPDX-License-Identifier: Apache-2.0
#include "bench/cases/bed_of_balls.h"

#include <fmt/format.h>

#include <cmath>

#include "engine/scenes/scene_file.h"

namespace thenar {

std::vector<std::string> bed_of_balls(int n) {
  if (n == 0) return {};
  const Scene scene = load_scene(THENAR_CONFIGS "/box_grasp.yaml");
  const Eigen::Isometry3d& X = scene.object.X_WO;
  constexpr double kRadius_m = 1e-3, kHalf_m = 22e-3, kRise_m = 0.2e-3;
  const int rows = static_cast<int>(std::lround(std::sqrt(0.5 * n))), columns = n / rows;
  const Eigen::Vector3d up = X.linear().col(2);
  std::string bodies;
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < columns; ++j) {
      const Eigen::Vector3d at_O(kHalf_m * (2.0 * i / (rows - 1) - 1.0), kHalf_m * (2.0 * j / (columns - 1) - 1.0),
                                 -25e-3 - kRadius_m);
      const Eigen::Vector3d p = X * at_O;
      bodies += fmt::format(
          "{}{{shape: {{sphere: 1 mm}}, position: [{} m, {} m, {} m], "
          "move: [{{by: [{} m, {} m, {} m], from: 0.1 s, over: 0.3 s}}]}}",
          bodies.empty() ? "" : ", ", p.x(), p.y(), p.z(), kRise_m * up.x(), kRise_m * up.y(), kRise_m * up.z());
    }
  }
  // The box is to stay over the bed.
  return {"task.translate.by=[0 mm, 1 mm, 0 mm]", fmt::format("environment={{friction: 0.2, bodies: [{}]}}", bodies)};
}

}  // namespace thenar
