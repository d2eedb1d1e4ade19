#include "app/window/live_settings.h"

#include <cmath>

#include "engine/results/state_message.h"
#include "engine/scenes/build_model.h"
#include "engine/scenes/key_table.h"
#include "engine/scenes/surface_model.h"

namespace thenar::window {

using nlohmann::ordered_json;

namespace {

constexpr Eigen::Index kFewestControls = 8;  // Fewer, and hardly one of them faces the object.

template <typename T>
void replace(const std::optional<T>& change, T& value) {
  if (change) value = *change;
}

/// Nothing if the bodies' frictions differ.
std::optional<double> same_friction(const Environment& environment) {
  std::optional<double> friction;
  for (const EnvironmentBody& body : environment.bodies) {
    if (friction && *friction != body.friction) return std::nullopt;
    friction = body.friction;
  }
  return friction;
}

const char* name_of(PulpKernel kernel) { return kernel == PulpKernel::kGaussian ? "gaussian" : "boussinesq"; }

}  // namespace

bool same_fingertips(const LiveSettings& a, const LiveSettings& b) {
  return a.kernel == b.kernel && a.level == b.level;
}

LiveSettings live_settings(const Model& model) {
  const Scene& scene = model.scene;
  LiveSettings settings;
  settings.friction = scene.contact.friction;
  settings.friction_steps = !scene.task.friction.empty();
  settings.tolerance = scene.contact.tolerance;
  settings.max_sweeps = scene.contact.max_sweeps;
  settings.contact_Hz = 1.0 / scene.step_s;
  settings.control_Hz = 1.0 / scene.control_period_s;
  settings.delay_periods = static_cast<int>(std::lround(scene.control_delay_s / scene.control_period_s));
  if (scene.control) settings.internal_force_N = scene.control->internal_force_N;
  if (scene.chooses_stiffness()) {
    settings.asked_N_per_m = scene.control->muscles->object_stiffness->translation_N_per_m;
    settings.asked_Nm_per_rad = scene.control->muscles->object_stiffness->rotation_Nm_per_rad;
  }
  if (scene.environment) {
    settings.around_friction = same_friction(*scene.environment);
    settings.around_m_per_N = scene.environment->compliance_m_per_N;
  }
  if (scene.fingertips) {
    settings.kernel = scene.fingertips->material.kernel;
    settings.level = model.level;
    settings.leaves = scene.fingertips->leaves;
  }
  return settings;
}

ordered_json settings_json(const LiveSettings& settings) {
  const auto or_null = [](const auto& value) { return value ? ordered_json(*value) : ordered_json(nullptr); };
  ordered_json json = {
      {"friction", settings.friction},           {"internal_force_N", or_null(settings.internal_force_N)},
      {"max_sweeps", settings.max_sweeps},       {"tolerance", settings.tolerance},
      {"contact_Hz", settings.contact_Hz},       {"control_Hz", settings.control_Hz},
      {"delay_periods", settings.delay_periods}, {"kernel", nullptr},
      {"level", or_null(settings.level)}};
  if (settings.kernel) json["kernel"] = name_of(*settings.kernel);
  const auto add = [&](const char* name, const std::optional<Eigen::Vector3d>& three) {
    if (three) json[name] = {three->x(), three->y(), three->z()};
  };
  add("asked_N_per_m", settings.asked_N_per_m);
  add("asked_Nm_per_rad", settings.asked_Nm_per_rad);
  if (settings.around_friction) json["around_friction"] = *settings.around_friction;
  if (settings.around_m_per_N) json["around_m_per_N"] = *settings.around_m_per_N;
  return json;
}

ordered_json settings_list(const LiveSettings& begun) {
  const ordered_json own = settings_json(begun);
  ordered_json list = ordered_json::array();
  for (const Key& key : scene_keys()) {
    const LiveKey& live = key.live;
    if (live.name.empty() || own.value(live.name, ordered_json()).is_null()) continue;
    ordered_json one = {{"name", live.name}, {"key", key.path}, {"label", live.label}, {"what", key.sentence}};
    if (live.least < live.most) {
      double most = live.most;
      while (live.name == "level" && most > 0.0 && (begun.leaves >> static_cast<int>(most)) < kFewestControls)
        most -= 1;
      one.update({{"type", key.items > 1 ? "numbers" : live.whole ? "whole" : "number"}, {"unit", live.unit}});
      one.update({{"least", live.least}, {"most", most}});
    } else {
      one.update({{"type", "choice"}, {"choices", words_of(key)}});
    }
    one["default"] = own.at(std::string(live.name));
    list.push_back(one);
  }
  return list;
}

ordered_json live_scene(const Model& model, const TriangleMesh& surface, const LiveSettings& begun) {
  ordered_json scene = scene_message(model, true, surface);
  scene["settings"] = settings_list(begun);
  return scene;
}

std::string change(const Set& changes, LiveSettings& settings) {
  if (changes.internal_force_N && !settings.internal_force_N) return "internal_force_N needs a scene with control";
  if ((changes.kernel || changes.level) && !settings.kernel) return "kernel and level need deformable fingertips";
  if (changes.level && (settings.leaves >> *changes.level) < kFewestControls) {
    return "level leaves a fingertip fewer than 8 control points";
  }
  if ((changes.asked_N_per_m || changes.asked_Nm_per_rad) && !settings.asked_N_per_m) {
    return "asked_N_per_m and asked_Nm_per_rad need a scene with control.muscles.object_stiffness";
  }
  if (changes.around_friction && !settings.around_friction) {
    return "around_friction needs a scene with an environment whose bodies have the same friction";
  }
  if (changes.around_m_per_N && !settings.around_m_per_N) return "around_m_per_N needs a scene with an environment";
  LiveSettings changed = settings;
  replace(changes.friction, changed.friction);
  if (changes.friction) changed.friction_steps = false;
  replace(changes.tolerance, changed.tolerance);
  replace(changes.max_sweeps, changed.max_sweeps);
  replace(changes.contact_Hz, changed.contact_Hz);
  replace(changes.control_Hz, changed.control_Hz);
  replace(changes.delay_periods, changed.delay_periods);
  if (changes.internal_force_N) changed.internal_force_N = changes.internal_force_N;
  if (changes.level) changed.level = changes.level;
  if (changes.asked_N_per_m) changed.asked_N_per_m = changes.asked_N_per_m;
  if (changes.asked_Nm_per_rad) changed.asked_Nm_per_rad = changes.asked_Nm_per_rad;
  if (changes.around_friction) changed.around_friction = changes.around_friction;
  if (changes.around_m_per_N) changed.around_m_per_N = changes.around_m_per_N;
  if (changes.kernel) {
    changed.kernel = *changes.kernel == "gaussian" ? PulpKernel::kGaussian : PulpKernel::kBoussinesq;
  }
  if (changed.control_Hz > (1.0 + 1e-9) * changed.contact_Hz) return "control_Hz must not be more than contact_Hz";
  settings = changed;
  return "";
}

LiveSettings carried_over(const LiveSettings& before, const LiveSettings& now, LiveSettings begun) {
  Set changes;
  const auto add = [](const auto& from, const auto& to, auto& wish) {
    if (to != from) wish = to;
  };
  // What takes the place of the task's steps may be the value that was there.
  if (now.friction != before.friction || now.friction_steps != before.friction_steps) changes.friction = now.friction;
  add(before.tolerance, now.tolerance, changes.tolerance);
  add(before.max_sweeps, now.max_sweeps, changes.max_sweeps);
  add(before.contact_Hz, now.contact_Hz, changes.contact_Hz);
  add(before.control_Hz, now.control_Hz, changes.control_Hz);
  add(before.delay_periods, now.delay_periods, changes.delay_periods);
  add(before.internal_force_N, now.internal_force_N, changes.internal_force_N);
  add(before.level, now.level, changes.level);
  add(before.asked_N_per_m, now.asked_N_per_m, changes.asked_N_per_m);
  add(before.asked_Nm_per_rad, now.asked_Nm_per_rad, changes.asked_Nm_per_rad);
  add(before.around_friction, now.around_friction, changes.around_friction);
  add(before.around_m_per_N, now.around_m_per_N, changes.around_m_per_N);
  if (now.kernel && now.kernel != before.kernel) changes.kernel = name_of(*now.kernel);
  (void)change(changes, begun);
  return begun;
}

void apply(const LiveSettings& now, const LiveSettings& settings, Scene& scene) {
  scene.contact.friction = settings.friction;
  if (!settings.friction_steps) scene.task.friction.clear();
  scene.contact.tolerance = settings.tolerance;
  scene.contact.max_sweeps = settings.max_sweeps;
  // Rates go through a reciprocal: what has not changed stays as it is, to the last bit.
  if (settings.contact_Hz != now.contact_Hz) scene.step_s = 1.0 / settings.contact_Hz;
  if (settings.control_Hz != now.control_Hz) scene.control_period_s = 1.0 / settings.control_Hz;
  if (settings.control_Hz != now.control_Hz || settings.delay_periods != now.delay_periods) {
    scene.control_delay_s = settings.delay_periods * scene.control_period_s;
  }
  if (settings.internal_force_N && settings.internal_force_N != now.internal_force_N) {
    scene.control->internal_force_N = *settings.internal_force_N;
  }
  if (settings.around_friction) {
    for (EnvironmentBody& body : scene.environment->bodies) body.friction = *settings.around_friction;
  }
  if (settings.around_m_per_N) scene.environment->compliance_m_per_N = *settings.around_m_per_N;
  if (settings.asked_N_per_m) {
    ObjectStiffness& asked = *scene.control->muscles->object_stiffness;
    asked.translation_N_per_m = *settings.asked_N_per_m;
    asked.rotation_Nm_per_rad = *settings.asked_Nm_per_rad;
  }
}

void apply(const LiveSettings& now, const LiveSettings& settings, Model& model) {
  apply(now, settings, model.scene);
  if (settings.kernel != now.kernel || settings.level != now.level) {
    set_fingertips(model, *settings.kernel, *settings.level);
  }
}

}  // namespace thenar::window
