#pragma once

#include <string>

#include "engine/grasp/scene.h"

/// Says in words what a scene models and what it leaves out, what each part of it costs and gives, and which defaults it
/// used. Runs the scene once for each part, which it says on standard error.
[[nodiscard]] std::string description(const thenar::Scene& scene);
