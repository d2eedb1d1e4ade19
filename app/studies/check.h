// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "engine/grasp/scene.h"

namespace thenar::app {

/// Says in words what a scene models and what it leaves out, and which defaults it used. `with_parts`: also what
/// becomes of the grasp, and what each part of the model costs and gives. For that the scene is run some dozens of
/// times, which takes from seconds to minutes, and is shown on a terminal.
[[nodiscard]] std::string description(const Scene& scene, bool with_parts);

}  // namespace thenar::app
