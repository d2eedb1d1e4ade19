// SPDX-License-Identifier: Apache-2.0
#include "bench/cases/resting.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "bench/cases/pads.h"
#include "bench/cases/scene_run.h"
#include "engine/scenes/scene_file.h"

namespace thenar {

std::vector<Resting> resting() {
  using Eigen::Vector3d;
  const PulpMaterial soft{1e6, 0.5, 5e-3};
  std::vector<Resting> all;
  for (const char* name : {"mug", "capsule", "box_edge"}) {
    const std::filesystem::path file = std::filesystem::path(THENAR_CONFIGS) / (std::string(name) + ".yaml");
    all.push_back({name, load_scene(file, {"object.points=12000"}), 3.0});
  }
  const Scene ball = scene_of(pads_round(SphereShape{25e-3}, 25e-3));
  all.push_back({"ball", ball});
  for (const int radius_mm : {8, 20, 60}) {
    const double radius_m = 1e-3 * radius_mm;
    all.push_back({"cylinder, R = " + std::to_string(radius_mm) + " mm",
                   scene_of(pads_across(CylinderShape{radius_m, 80e-3}, 2.0 * radius_m, 22e-3))});
  }
  const SuperquadricShape superquadric{Vector3d(40e-3, 50e-3, 60e-3), {0.6, 0.8}};
  all.push_back({"superquadric", scene_of(pads_across(superquadric, 40e-3, 14e-3))});
  all.push_back({"soft ball", ball});
  all.back().scene.object.compliance = soft;
  all.push_back({"soft box", scene_of(pads_across(BoxShape{Vector3d(50e-3, 50e-3, 50e-3)}, 50e-3, 22e-3))});
  all.back().scene.object.compliance = soft;
  return all;
}

}  // namespace thenar
