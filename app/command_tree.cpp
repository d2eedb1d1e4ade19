// SPDX-License-Identifier: Apache-2.0
#include "app/command_tree.h"

#include <CLI/CLI.hpp>
#include <functional>

namespace thenar::app {

namespace {

/// The options of a command, and of its groups, which CLI11 keeps as commands without a name.
std::vector<const CLI::Option*> options_of(const CLI::App& command,
                                           const std::function<bool(const CLI::Option*)>& are_wanted) {
  std::vector<const CLI::Option*> options = command.get_options(are_wanted);
  for (const CLI::App* below : command.get_subcommands({})) {
    if (!below->get_name().empty()) continue;
    const std::vector<const CLI::Option*> more = options_of(*below, are_wanted);
    options.insert(options.end(), more.begin(), more.end());
  }
  return options;
}

}  // namespace

std::vector<const CLI::App*> commands_of(const CLI::App& command) {
  return command.get_subcommands([](const CLI::App* below) { return !below->get_name().empty(); });
}

std::vector<const CLI::Option*> arguments_of(const CLI::App& command) {
  return options_of(command, [](const CLI::Option* option) { return option->get_positional(); });
}

std::vector<const CLI::Option*> flags_of(const CLI::App& command) {
  return options_of(command, [](const CLI::Option* option) { return !option->get_positional(); });
}

bool takes_value(const CLI::Option& option) { return option.get_items_expected_max() > 0; }

std::string value_name(const CLI::Option& option) {
  return option.get_positional() ? option.get_name(true) : option.get_type_name();
}

}  // namespace thenar::app
