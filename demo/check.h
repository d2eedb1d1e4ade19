#pragma once

#include <string>

#include "engine/scene.h"

/// Says in words what a scene models, what it leaves out, and which defaults it used.
[[nodiscard]] std::string description(const thenar::Scene& scene);
