// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "app/options.h"

namespace thenar::app {

/// Runs `thenar export`: a recording as one page that plays without a network, or as a table. Returns the exit code.
[[nodiscard]] int export_recording(const Options& options);

}  // namespace thenar::app
