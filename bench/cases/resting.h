// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/cases/pads.h"
#include "bench/cases/scene_run.h"
#include "engine/scenes/scene_file.h"

namespace thenar {

/// A scene in which everything comes to rest.
struct Resting {
  std::string name;
  Scene scene;
  double at_rest_s = 0.8;
};

/// Objects that are curved, have edges or are soft, held by the hand or by pads.
std::vector<Resting> resting();

}  // namespace thenar
