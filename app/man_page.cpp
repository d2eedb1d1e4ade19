// SPDX-License-Identifier: Apache-2.0
#include "app/man_page.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <string_view>

#include "app/command_tree.h"
#include "engine/formats/build_info.h"

namespace thenar::app {

namespace {

/// Text as roff shows it: a dash is no hyphen, for it is typed, and no line begins with a request.
std::string roff(std::string_view text) {
  std::string shown;
  for (const char c : text) {
    if (c == '\\') {
      shown += "\\e";
    } else if (c == '-') {
      shown += "\\-";
    } else {
      const bool begins_line = shown.empty() || shown.back() == '\n';
      shown += begins_line && (c == '.' || c == '\'') ? std::string("\\&") + c : std::string(1, c);
    }
  }
  return shown;
}

/// Paragraphs of lines that each end where the text has a line's end.
std::string paragraphs(std::string text) {
  std::string shown;
  for (std::size_t end = 0; !text.empty(); text.erase(0, end)) {
    end = text.find('\n');
    shown += ".PP\n" + roff(text.substr(0, end)) + '\n';
    end = end == std::string::npos ? text.size() : end + 1;
  }
  return shown;
}

std::string meaning(const CLI::Option& option) {
  std::string text = option.get_description();
  if (!option.get_default_str().empty()) text += fmt::format(" (default: {})", option.get_default_str());
  if (!option.get_envname().empty()) text += fmt::format(" (environment: {})", option.get_envname());
  if (option.get_required()) text += " (required)";
  return roff(text);
}

std::string item(const CLI::Option& option) {
  if (option.get_positional())
    return fmt::format(".TP\n\\fI{}\\fR\n{}\n", roff(option.get_name(true)), meaning(option));
  std::string names;
  for (const std::string& name : option.get_snames()) names += fmt::format("\\fB\\-{}\\fR, ", roff(name));
  for (const std::string& name : option.get_lnames()) names += fmt::format("\\fB\\-\\-{}\\fR, ", roff(name));
  names.resize(names.size() - 2);
  if (takes_value(option)) names += fmt::format(" \\fI{}\\fR", roff(value_name(option)));
  return fmt::format(".TP\n{}\n{}\n", names, meaning(option));
}

/// The section of a command, then those of the commands below it.
std::string section(const CLI::App& command, const std::string& before) {
  const std::string name = before + " " + command.get_name();
  std::string heading = name;
  for (const CLI::Option* argument : arguments_of(command)) {
    std::string place = argument->get_name(true);
    if (argument->get_items_expected_max() > 1) place += " ...";
    heading += argument->get_required() ? " " + place : " [" + place + "]";
  }
  std::string text = fmt::format(".SS \"{} [OPTIONS]\"\n{}.\n", roff(heading), roff(command.get_description()));
  for (const CLI::Option* argument : arguments_of(command)) text += item(*argument);
  for (const CLI::Option* flag : flags_of(command)) text += item(*flag);
  text += paragraphs(command.get_footer());
  for (const CLI::App* below : commands_of(command)) text += section(*below, name);
  return text;
}

}  // namespace

std::string man_page(const CLI::App& program) {
  std::string text =
      fmt::format(".TH THENAR 1 \"{}\" \"thenar {}\" \"User Commands\"\n", build_info::kReleased, build_info::kVersion);
  text += fmt::format(".SH NAME\nthenar \\- {}\n", roff(program.get_description()));
  text += ".SH SYNOPSIS\n.B thenar\n\\fICOMMAND\\fR [\\fIARGUMENTS\\fR] [\\fIOPTIONS\\fR]\n.br\n.B thenar\n";
  text += "\\fB\\-\\-help\\fR | \\fB\\-\\-version\\fR\n.SH COMMANDS\n";
  for (const CLI::App* command : commands_of(program)) text += section(*command, "thenar");
  text += ".SH \"EXIT STATUS\"\n" + paragraphs(program.get_footer()).substr(sizeof ".PP");
  text += ".SH \"SEE ALSO\"\n\\fBgnuplot\\fR(1), which draws the figures of a run.\n";
  return text;
}

}  // namespace thenar::app
