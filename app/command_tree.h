// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

/// The command line as it is described to CLI11, for what is made of it beside the help.
namespace thenar::app {

/// Returns the commands below this one, in the order of the help.
[[nodiscard]] std::vector<const CLI::App*> commands_of(const CLI::App& command);
/// Returns the arguments that have a place and no flag, in their order.
[[nodiscard]] std::vector<const CLI::Option*> arguments_of(const CLI::App& command);
/// Returns the flags, those of groups, too, in the order of the help.
[[nodiscard]] std::vector<const CLI::Option*> flags_of(const CLI::App& command);

/// Returns true for an argument, and for a flag that a value follows.
[[nodiscard]] bool takes_value(const CLI::Option& option);
/// Returns what the value is, as the help names it: SCENE, FILE, "text|json". Words in capitals stand for values.
[[nodiscard]] std::string value_name(const CLI::Option& option);

}  // namespace thenar::app
