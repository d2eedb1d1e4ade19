// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "app/options.h"

namespace thenar::app {

/// Runs `thenar solve`: solves problem files and prints how well and how fast. Returns 0 if every verdict is right and
/// every solution within the tolerance, else 6; 2 for a method that does not go with a file. Throws FileError.
[[nodiscard]] int solve(const Options& options);

}  // namespace thenar::app
