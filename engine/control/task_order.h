// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "engine/grasp/scene.h"

namespace thenar {

/// Describes why phase i cannot follow those before it; empty if it can. A task begins with the object in the hand, or
/// with open fingers if approach or close is its first phase.
[[nodiscard]] std::string order_fault(const std::vector<Phase>& phases, std::size_t i);

}  // namespace thenar
