#pragma once

#include "app/options.h"

namespace thenar::app {

/// `thenar sweep`: runs all combinations of what varies in a scene, here or under mpirun, and makes one table of them.
/// Its exit code: 0 if every row was run, whatever became of it. Throws ConfigError and FileError.
[[nodiscard]] int sweep(const Options& options);

}  // namespace thenar::app
