// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "app/options.h"

namespace thenar::app {

/// Runs `thenar sweep`: all combinations of the varied values of a scene, here or under mpirun, as one table.
/// Returns 0 if every row was run, whatever became of it. Throws ConfigError and FileError.
[[nodiscard]] int sweep(const Options& options);

}  // namespace thenar::app
