// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace thenar::app {

/// Returns what the last of these words can become, for the shells' completions in app/completion. `words` are those of
/// a command line behind the program's name; the last one may be empty. A line is a candidate, a tab and what it means.
/// At the end a line ":files" or ":folders" stands for the names of those.
[[nodiscard]] std::string completions(const CLI::App& program, const std::vector<std::string>& words);

}  // namespace thenar::app
