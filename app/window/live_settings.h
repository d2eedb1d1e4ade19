#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "app/window/message.h"
#include "collision/triangle_mesh.h"
#include "engine/grasp/model.h"

namespace thenar::window {

/// What of a running scene can be changed. Nothing: the scene has no such thing.
struct LiveSettings {
  double friction = 0.0, tolerance = 0.0, contact_Hz = 0.0, control_Hz = 0.0;
  bool friction_steps = false;  ///< The task changes friction at its own times, until somebody sets it.
  int max_sweeps = 0, delay_periods = 0;
  std::optional<double> internal_force_N;
  std::optional<thenar::PulpKernel> kernel;
  std::optional<int> level;
  std::optional<Eigen::Vector3d> asked_N_per_m, asked_Nm_per_rad;  ///< Of a scene that chooses a stiffness.
  std::optional<double> around_friction;  ///< Of an environment whose bodies all have the same.
  std::optional<double> around_m_per_N;   ///< Compliance of the environment.
  Eigen::Index leaves = 0;                ///< Of a fingertip; stays.

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

[[nodiscard]] bool same_fingertips(const LiveSettings& a, const LiveSettings& b);
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
[[nodiscard]] std::string change(const Set& changes, LiveSettings& settings);

/// The settings of a scene that begins with `begun`, and with what somebody changed from `before` to `now` while it was
/// being made: all of that, or nothing if the scene cannot have it.
[[nodiscard]] LiveSettings carried_over(const LiveSettings& before, const LiveSettings& now, LiveSettings begun);

/// Writes into the scene, whose settings are `now`, what differs from them; but for kernel and level.
void apply(const LiveSettings& now, const LiveSettings& settings, thenar::Scene& scene);

/// Writes into the model, whose settings are `now`, what differs from them.
void apply(const LiveSettings& now, const LiveSettings& settings, thenar::Model& model);

}  // namespace thenar::window
