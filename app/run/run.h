// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "app/options.h"

namespace thenar::app {

/// Runs `thenar run`: runs a scene in one loop, in two on a virtual clock, or on two threads in real time; prints its
/// measures, writes its results and draws its figures. Returns the exit code. Throws ConfigError and FileError.
[[nodiscard]] int run(const Options& options);

}  // namespace thenar::app
