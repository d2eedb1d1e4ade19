// SPDX-License-Identifier: Apache-2.0
#include "app/completion.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <sstream>
#include <string_view>

#include "app/command_tree.h"
#include "engine/scenes/key_table.h"
#include "engine/scenes/shared_data.h"

namespace thenar::app {

namespace {

/// The lines for one word, of which `before` stays and `begun` is to be completed.
class Candidates {
 public:
  Candidates(std::string before, std::string begun) : before_(std::move(before)), begun_(std::move(begun)) {}

  void add(std::string_view word, std::string_view meaning = "") {
    if (!word.starts_with(begun_)) return;
    text_ += fmt::format("{}{}\t{}\n", before_, word, meaning.substr(0, meaning.find('\n')));
  }
  void also(const char* names) { names_ = fmt::format(":{}\n", names); }
  [[nodiscard]] const std::string& begun() const { return begun_; }
  [[nodiscard]] std::string text() const { return text_ + names_; }

 private:
  std::string before_, begun_, text_, names_;
};

/// The keys of a scene that `--set` may change, but for whole maps: those in lists have no path of their own.
void add_keys_with_value(Candidates& candidates) {
  std::string list = "-";
  for (const Key& key : scene_keys()) {
    if (key.path.starts_with(list)) continue;
    if (key.kind == KeyKind::kMaps) list = key.path + ".";
    if (key.kind != KeyKind::kMap) candidates.add(key.path + "=", key.sentence);
  }
}

/// Values by the name that the help gives them: each of its words in capitals is a kind, each other one a value.
void add_values(Candidates& candidates, const std::string& name) {
  std::istringstream kinds(name);
  for (std::string kind; std::getline(kinds, kind, '|');) {
    if (kind == "SCENE") {
      for (const KnownScene& scene : known_scenes()) candidates.add(scene.name, scene.about);
    } else if (kind == "HAND") {
      for (const std::string& hand : known_hands()) candidates.add(hand, "a hand that comes with the program");
    } else if (kind == "KEY" || kind == "PREFIX") {
      for (const Key& key : scene_keys()) candidates.add(key.path, key.sentence);
    } else if (kind.starts_with("KEY=")) {
      add_keys_with_value(candidates);
    } else if (std::ranges::none_of(kind, [](char c) { return c >= 'A' && c <= 'Z'; })) {
      candidates.add(kind);
    }
    if (kind == "SCENE" || kind == "HAND" || kind == "FILE" || kind == "OBJECT") candidates.also("files");
    if (kind == "DIR") candidates.also("folders");
  }
}

const CLI::Option* flag_called(const CLI::App& command, std::string_view word) {
  for (const CLI::Option* flag : flags_of(command)) {
    const std::vector<std::string>& names = flag->get_lnames();
    if (word.starts_with("--") && std::ranges::find(names, word.substr(2)) != names.end()) return flag;
  }
  return nullptr;
}

/// Where a command line stands before its last word.
struct Place {
  const CLI::App* command;
  std::size_t arguments = 0;          ///< How many of its arguments are there.
  const CLI::Option* flag = nullptr;  ///< The flag whose value comes next.
};

void go_on(Place& place, const std::string& word) {
  if (place.flag != nullptr) {
    place.flag = nullptr;
  } else if (word.starts_with('-')) {
    const CLI::Option* const flag = flag_called(*place.command, word);
    if (flag != nullptr && takes_value(*flag)) place.flag = flag;
  } else {
    for (const CLI::App* below : commands_of(*place.command)) {
      if (place.arguments > 0 || below->get_name() != word) continue;
      place.command = below;
      return;
    }
    ++place.arguments;
  }
}

/// What may stand behind the flag and the arguments that are there.
void add_next(Candidates& candidates, const Place& place) {
  if (candidates.begun().starts_with('-')) {
    for (const CLI::Option* flag : flags_of(*place.command)) {
      for (const std::string& name : flag->get_lnames()) candidates.add("--" + name, flag->get_description());
    }
    return;
  }
  if (place.arguments == 0) {
    for (const CLI::App* below : commands_of(*place.command))
      candidates.add(below->get_name(), below->get_description());
  }
  const std::vector<const CLI::Option*> arguments = arguments_of(*place.command);
  if (arguments.empty()) return;
  const bool last_again = arguments.back()->get_items_expected_max() > 1;
  if (place.arguments >= arguments.size() && !last_again) return;
  const CLI::Option& argument = *arguments[std::min(place.arguments, arguments.size() - 1)];
  add_values(candidates, value_name(argument));
}

}  // namespace

std::string completions(const CLI::App& program, const std::vector<std::string>& words) {
  if (words.empty()) return "";
  Place place{&program};
  for (auto word = words.begin(); word != words.end() - 1; ++word) {
    // A shell may part `--flag=value` at its sign.
    if (*word != "=") go_on(place, *word);
  }
  const std::string& last = words.back();
  const std::size_t sign = last.starts_with("--") ? last.find('=') : std::string::npos;
  if (sign != std::string::npos) go_on(place, last.substr(0, sign));
  const std::size_t begin = sign == std::string::npos ? 0 : sign + 1;
  Candidates candidates(last.substr(0, begin), last == "=" ? "" : last.substr(begin));
  if (place.flag != nullptr) {
    add_values(candidates, value_name(*place.flag));
  } else {
    add_next(candidates, place);
  }
  return candidates.text();
}

}  // namespace thenar::app
