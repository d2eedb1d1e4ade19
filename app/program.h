#pragma once

#include <functional>
#include <map>
#include <string>

#include "app/options.h"

namespace thenar::app {

/// What each command does, by its name. Returns the exit code.
using Commands = std::map<std::string, std::function<int(const Options&)>>;

/// A program of several that have one command line, from its arguments to its exit code: runs the command if it is one
/// of `commands`, and else becomes `other`, which stands beside it. Errors are told on stderr.
[[nodiscard]] int run_program(int argc, char** argv, const Commands& commands, const std::string& other);

/// Prints on stdout. Returns the exit code.
[[nodiscard]] int print(const std::string& text);

}  // namespace thenar::app
