#pragma once

#include <string>

#include "engine/scene.h"

/// Says in words what a scene models, what it leaves out, and which defaults it used.
[[nodiscard]] std::string description(const thenar::Scene& scene);

/// Whether this machine has the instructions that the build uses.
[[nodiscard]] bool host_can_run();
