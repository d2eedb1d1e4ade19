// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "app/options.h"

namespace thenar::app {

/// Tells how the scene's peg goes into its hole. Returns the exit code.
[[nodiscard]] int insertion(const Options& options);

}  // namespace thenar::app
