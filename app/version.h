// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace thenar::app {

/// Returns what `--version` prints of every program: version, commit, compiler, flags and parts.
[[nodiscard]] std::string version_text();

}  // namespace thenar::app
