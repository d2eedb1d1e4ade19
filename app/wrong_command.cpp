// SPDX-License-Identifier: Apache-2.0
#include "app/wrong_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <string_view>
#include <vector>

#include "engine/formats/text.h"

namespace thenar::app {

namespace {

/// What is wrong with words that no flag takes, of which the first one with a dash is told.
std::string unexpected(const CLI::App& command, const std::vector<std::string>& words) {
  std::vector<std::string> flags;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) flags.push_back("--" + name);
  }
  const std::vector<std::string_view> candidates(flags.begin(), flags.end());
  for (const std::string& word : words) {
    if (!word.starts_with('-')) continue;
    const std::string flag = word.substr(0, word.find('='));
    return fmt::format("there is no flag {}{}", printable(flag), did_you_mean(nearest_word(flag, candidates)));
  }
  return fmt::format("'{}' is a word too many", printable(words.empty() ? "" : words.back()));
}

}  // namespace

std::string wrong_command_line(const CLI::App* app, const CLI::Error& error) {
  const CLI::App* command = app;
  std::string name = app->get_name();
  while (!command->get_subcommands().empty()) {
    command = command->get_subcommands().front();
    name += " " + command->get_name();
  }
  std::string what = error.what();
  bool needs_help = true;
  if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::ExtrasError)) {
    what = unexpected(*command, app->remaining(true));
  } else if (const std::size_t missing = what.find(": 1 required "); missing != what.npos) {
    what = what.substr(0, missing) + ": its value is missing";
  } else if (const std::size_t list = what.find("option from ["); list != what.npos) {
    const std::size_t begin = list + 13;
    what = "name at least one of " + what.substr(begin, what.find(']') - begin);
  } else {
    needs_help = error.get_exit_code() == static_cast<int>(CLI::ExitCodes::RequiredError);
  }
  const char* const mark = what.ends_with('?') ? "" : ";";
  return needs_help ? fmt::format("{}{} `{} --help` lists what it takes\n", what, mark, name) : what + "\n";
}

}  // namespace thenar::app
