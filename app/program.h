// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <string>

#include "app/options.h"

namespace thenar::app {

/// Commands of a program by name; each returns the exit code.
using Commands = std::map<std::string, std::function<int(const Options&)>>;

/// Runs a program of several that have one command line, and returns its exit code: does the command if it is one of
/// `commands`, and else becomes the program `other` of the same folder. Prints errors on stderr.
[[nodiscard]] int run_program(int argc, char** argv, const Commands& commands, const std::string& other);

/// Prints on stdout. Returns the exit code.
[[nodiscard]] int print(const std::string& text);

}  // namespace thenar::app
