#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "app/window/message.h"
#include "collision/triangle_mesh.h"
#include "engine/grasp/model.h"

namespace thenar::window {

/// What of a running scene can be changed: the keys of its description that have a LiveKey (engine/scenes/keys.h).
struct LiveSettings {
  LiveValues values;            ///< Of those that the scene has.
  bool friction_steps = false;  ///< The task changes friction at its own times, until somebody sets it.
  Eigen::Index leaves = 0;      ///< Of a fingertip; stays.

  /// The value of a LiveKey's name; nothing: the scene does not have it.
  [[nodiscard]] std::optional<LiveValue> value(std::string_view name) const;
  /// The number of a LiveKey's name. Requires that the scene has it, and that it is a number.
  [[nodiscard]] double number(std::string_view name) const;

  [[nodiscard]] bool operator==(const LiveSettings&) const = default;
};

/// What the pages want.
struct Wanted {
  bool paused = false;
  double speed = 1.0;
  int steps = 0;             ///< Yet to be done.
  bool reset = false;        ///< Yet to be done.
  std::optional<Take> take;  ///< Likewise.
  LiveSettings settings;
  LiveSettings begun;  ///< As the scene had them when it began.

  [[nodiscard]] bool operator==(const Wanted&) const = default;
};

/// Whether kernel and level of the fingertips are alike.
[[nodiscard]] bool same_fingertips(const LiveSettings& a, const LiveSettings& b);
/// Gives `to` kernel and level of `from`, the settings of the same scene.
void copy_fingertips(const LiveSettings& from, LiveSettings& to);

/// The settings that a model has. Its level is the one that it was made with, also where the scene leaves the choice.
[[nodiscard]] LiveSettings live_settings(const thenar::Model& model);
/// As a status message has them.
[[nodiscard]] nlohmann::ordered_json settings_json(const LiveSettings& settings);
/// What a scene message says of those that the scene has, for controls: from the table of keys. `begun`: as the scene
/// had them when it began.
[[nodiscard]] nlohmann::ordered_json settings_list(const LiveSettings& begun);

/// The scene message of a running scene: with these settings.
[[nodiscard]] nlohmann::ordered_json live_scene(const thenar::Model& model, const thenar::TriangleMesh& surface,
                                                const LiveSettings& begun);

/// Makes the changes, or says why they cannot be made; then none is.
[[nodiscard]] std::string change(const Set& set, LiveSettings& settings);

/// The settings of a scene that begins with `begun`, and with what somebody changed from `before` to `now` while it was
/// being made: all of that, or nothing if the scene cannot have it.
[[nodiscard]] LiveSettings carried_over(const LiveSettings& before, const LiveSettings& now, LiveSettings begun);

/// Writes into the scene, whose settings are `now`, what differs from them. All else stays as it is, to the last bit.
void apply(const LiveSettings& now, const LiveSettings& settings, thenar::Scene& scene);

/// Writes into the model, whose settings are `now`, what differs from them.
void apply(const LiveSettings& now, const LiveSettings& settings, thenar::Model& model);

}  // namespace thenar::window
