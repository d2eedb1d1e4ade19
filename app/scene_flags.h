// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "engine/grasp/scene.h"
#include "engine/scenes/scene_file.h"
#include "engine/scenes/units.h"

namespace CLI {
class App;
class Option;
class Validator;
}  // namespace CLI

namespace thenar::app {

// Flags that change a scene, for all commands that run one.

/// The rates of the two loops.
struct RateFlags {
  std::string contact, control;  ///< As written; empty: not asked for.

  [[nodiscard]] bool any() const { return !contact.empty() || !control.empty(); }
  [[nodiscard]] bool auto_control() const { return control == "auto"; }  ///< The control rate is to be measured.
  /// Returns the changes that the rates make in the scene.
  [[nodiscard]] std::vector<std::string> changes() const;
  /// Returns the values where neither the rates nor the user's changes set any: 4 kHz and 1 kHz.
  [[nodiscard]] std::vector<std::string> defaults() const;
};

/// Returns the default stopping rule of a contact tick in real time.
[[nodiscard]] std::vector<std::string> realtime_defaults();

/// Returns a check for CLI11 that a text is a quantity within [low, high]: the error, or nothing.
[[nodiscard]] CLI::Validator quantity(Dimension dimension, double low, double high, const char* example);
[[nodiscard]] double time_s(const std::string& text);
/// Reads what 1 in an object's file measures: a unit of length, or a length.
[[nodiscard]] Quantity read_unit(const std::string& text);
/// Returns a time with its unit: seconds where it has none.
[[nodiscard]] std::string with_unit(const std::string& text);
/// Returns a check that a text is a time, with a unit or without.
[[nodiscard]] CLI::Validator some_time();
/// Return checks that a text is a name, and that it is not that of a folder.
[[nodiscard]] CLI::Validator named();
[[nodiscard]] CLI::Validator no_folder();

/// Return checks that a text is a number, or a whole number, within [low, high].
[[nodiscard]] CLI::Validator within(double low, double high);
[[nodiscard]] CLI::Validator whole_within(std::int64_t low, std::int64_t high);

/// Adds a flag whose value is one of these words; help and completions name them.
CLI::Option* add_choice(CLI::App& command, const char* flag, std::string& value, const std::vector<std::string>& words,
                        const char* description);

/// Adds --core.
void add_core(CLI::App& command, int& core);

/// Adds SCENE and --set. With `or_hand` SCENE may be a hand, too.
void add_scene(
    CLI::App& command, std::filesystem::path& scene, std::vector<std::string>& overrides,
    const char* description = "Scene file (YAML), or the name of a scene that comes with the program: thenar scenes",
    bool or_hand = false);
/// Adds --contact-rate and --control-rate, which may be `auto` with `may_be_auto`.
void add_rates(CLI::App& command, RateFlags& rates, bool may_be_auto);
/// Throws CLI::ValidationError if the rates do not go together.
void check_rates(const RateFlags& rates);

/// Returns the scene with its changes, which include those of the rates. Its ConfigError names the flag
/// where rates do not go together.
[[nodiscard]] Scene scene_at_rates(const std::filesystem::path& scene, const std::vector<std::string>& overrides,
                                   const RateFlags& rates);

}  // namespace thenar::app
