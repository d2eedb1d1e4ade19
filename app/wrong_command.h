// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace CLI {
class App;
class Error;
}  // namespace CLI

namespace thenar::app {

/// Returns in one line what is wrong with a command line, for App::failure_message() of CLI11.
[[nodiscard]] std::string wrong_command_line(const CLI::App* app, const CLI::Error& error);

}  // namespace thenar::app
