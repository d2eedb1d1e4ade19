#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/grasp/scene.h"
#include "engine/scenes/scene_file.h"
#include "engine/scenes/units.h"

namespace CLI {
class App;
class Validator;
}  // namespace CLI

namespace thenar::app {

// The flags that change a scene, of all commands that run one.

/// The rates of the two loops.
struct RateFlags {
  std::string contact, control;  ///< As written; empty: not asked for.

  [[nodiscard]] bool any() const { return !contact.empty() || !control.empty(); }
  [[nodiscard]] bool auto_control() const { return control == "auto"; }  ///< It is to be measured.
  /// What they change in the scene,
  [[nodiscard]] std::vector<std::string> changes() const;
  /// and what holds where neither they nor the user's changes say anything: 4 kHz and 1 kHz.
  [[nodiscard]] std::vector<std::string> defaults() const;
};

/// When a contact tick stops in real time, unless somebody says otherwise.
[[nodiscard]] std::vector<std::string> realtime_defaults();

/// Whether the text is a quantity within [low, high], as CLI11 asks: what is wrong, or nothing.
[[nodiscard]] CLI::Validator quantity(Dimension dimension, double low, double high, const char* example);
[[nodiscard]] double time_s(const std::string& text);
/// A time without a unit is one of seconds.
[[nodiscard]] std::string with_unit(const std::string& text);
/// Whether the text is a time, with a unit or without.
[[nodiscard]] CLI::Validator some_time();
/// Whether the text is a name, and not that of a folder.
[[nodiscard]] CLI::Validator named();
[[nodiscard]] CLI::Validator no_folder();

/// --core.
void add_core(CLI::App& command, int& core);

/// SCENE and --set. With `or_hand` it may be a hand, too.
void add_scene(
    CLI::App& command, std::filesystem::path& scene, std::vector<std::string>& overrides,
    const char* description = "Scene file (YAML), or the name of a scene that comes with the program: thenar scenes",
    bool or_hand = false);
/// --contact-rate and --control-rate, which may be `auto`, or not.
void add_rates(CLI::App& command, RateFlags& rates, bool may_be_auto);
/// Throws CLI::ValidationError if the rates do not go together.
void check_rates(const RateFlags& rates);

/// The scene with its changes, which have those of the rates. ConfigError names the flag where rates do not go
/// together.
[[nodiscard]] Scene scene_at_rates(const std::filesystem::path& scene, const std::vector<std::string>& overrides,
                                   const RateFlags& rates);

}  // namespace thenar::app
