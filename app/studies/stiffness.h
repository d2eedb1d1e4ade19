// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "app/stiffness_flags.h"

namespace thenar::app {

/// Prints the stiffness of a scene's object in the hand. Returns the exit code.
[[nodiscard]] int run_stiffness(const StiffnessOptions& options);

}  // namespace thenar::app
