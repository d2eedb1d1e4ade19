#pragma once

#include <string>
#include <vector>

#include "engine/grasp/scene.h"

namespace thenar {

/// Why phase i of these cannot come after those before it, in words; empty if it can. A task begins with the object in
/// the hand, or with open fingers if approach or close is its first phase.
[[nodiscard]] std::string order_fault(const std::vector<Phase>& phases, std::size_t i);

}  // namespace thenar
