// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "app/hand_flags.h"

namespace thenar::app {

/// Prints the largest forces that a scene's hand can give at its start. Returns the exit code.
[[nodiscard]] int run_hand_capacity(const CapacityOptions& options);

}  // namespace thenar::app
