// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace CLI {
class App;
}

namespace thenar::app {

/// Returns the manual page thenar(1), in roff, of the description of the command line.
[[nodiscard]] std::string man_page(const CLI::App& program);

}  // namespace thenar::app
