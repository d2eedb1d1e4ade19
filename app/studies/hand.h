// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "app/hand_flags.h"

namespace thenar::app {

/// Lists and draws a hand, makes one of an MJCF or URDF file, or finds what one can give. Returns the exit code.
[[nodiscard]] int run_hand(const HandOptions& options);

}  // namespace thenar::app
