#pragma once

#include "app/options.h"

namespace thenar::app {

/// `thenar solve`: solves problem files and says how well and how fast. Its exit code: 0 if every verdict is right and
/// every solution within the tolerance, else 6; 2 for a method that does not go with a file. Throws FileError.
[[nodiscard]] int solve(const Options& options);

}  // namespace thenar::app
