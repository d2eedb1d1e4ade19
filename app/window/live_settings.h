// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "app/window/message.h"
#include "collision/triangle_mesh.h"
#include "engine/grasp/model.h"

namespace thenar::window {

/// Changeable settings of a running scene: the keys of its description that have a LiveKey (engine/scenes/keys.h).
struct LiveSettings {
  LiveValues values;            ///< Values of the keys that the scene has.
  bool friction_steps = false;  ///< The task changes friction at its own times, until somebody sets it.
  Eigen::Index leaves = 0;      ///< Leaves of a fingertip; fixed.

  /// Returns the value of a LiveKey's name; nothing: the scene does not have it.
  [[nodiscard]] std::optional<LiveValue> value(std::string_view name) const;
  /// Returns the number of a LiveKey's name. Requires that the scene has it, and that it is a number.
  [[nodiscard]] double number(std::string_view name) const;

  [[nodiscard]] bool operator==(const LiveSettings&) const = default;
};

/// Requests of the pages.
struct Wanted {
  bool paused = false;
  double speed = 1.0;
  int steps = 0;             ///< Pending steps.
  bool reset = false;        ///< Pending reset.
  std::optional<Take> take;  ///< Pending grasp.
  bool record = false;       ///< A recording is to be made.
  LiveSettings settings;
  LiveSettings begun;  ///< Settings at the scene's beginning.

  [[nodiscard]] bool operator==(const Wanted&) const = default;
};

/// Returns true if kernel and level of the fingertips are alike.
[[nodiscard]] bool same_fingertips(const LiveSettings& a, const LiveSettings& b);
/// Gives `to` kernel and level of `from`, the settings of the same scene.
void copy_fingertips(const LiveSettings& from, LiveSettings& to);

/// Returns the settings of a model. The level is that of its making, also where the scene leaves the choice.
[[nodiscard]] LiveSettings live_settings(const thenar::Model& model);
/// Returns the settings as in a status message.
[[nodiscard]] nlohmann::ordered_json settings_json(const LiveSettings& settings);
/// Returns the list of the scene's settings in a scene message, for controls: from the table of keys. `begun`: their
/// values at its beginning.
[[nodiscard]] nlohmann::ordered_json settings_list(const LiveSettings& begun);

/// Returns the scene message of a running scene, with these settings.
[[nodiscard]] nlohmann::ordered_json live_scene(const thenar::Model& model, const thenar::TriangleMesh& surface,
                                                const LiveSettings& begun);

/// Makes the changes, or returns why they cannot be made; then none is.
[[nodiscard]] std::string change(const Set& set, LiveSettings& settings);

/// Returns the settings of a scene that begins with `begun` and the changes made from `before` to `now` while it was
/// being made: all of them, or nothing if the scene cannot have it.
[[nodiscard]] LiveSettings carried_over(const LiveSettings& before, const LiveSettings& now, LiveSettings begun);

/// Writes into the scene, whose settings are `now`, those that differ. All else stays as it is, to the last bit.
void apply(const LiveSettings& now, const LiveSettings& settings, thenar::Scene& scene);

/// Writes into the model, whose settings are `now`, those that differ.
void apply(const LiveSettings& now, const LiveSettings& settings, thenar::Model& model);

}  // namespace thenar::window
