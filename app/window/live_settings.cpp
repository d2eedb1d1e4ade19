// SPDX-License-Identifier: Apache-2.0
#include "app/window/live_settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "engine/models/build_model.h"
#include "engine/models/surface_model.h"
#include "engine/recordings/state_message.h"
#include "engine/scenes/describe.h"
#include "engine/scenes/key_table.h"

namespace thenar::window {

using nlohmann::ordered_json;

namespace {

constexpr Eigen::Index kFewestControls = 8;  // Fewer, and hardly one of them faces the object.

/// Each status has these, in this order, null where the scene does not; others follow as the table of keys has them.
constexpr std::string_view kInEachStatus[]{"friction",   "internal_force_N", "max_sweeps", "tolerance", "contact_Hz",
                                           "control_Hz", "delay_periods",    "kernel",     "level"};

// Why a scene does not have a setting, in the order in which this is told.
constexpr std::string_view kNeedsFingertips = "kernel and level need deformable fingertips";
constexpr std::string_view kNeedsStiffness =
    "asked_N_per_m and asked_Nm_per_rad need a scene with control.muscles.object_stiffness";
constexpr std::pair<std::string_view, std::string_view> kNeeds[]{
    {"internal_force_N", "internal_force_N needs a scene with control"},
    {"kernel", kNeedsFingertips},
    {"level", kNeedsFingertips},
    {"asked_N_per_m", kNeedsStiffness},
    {"asked_Nm_per_rad", kNeedsStiffness},
    {"around_friction", "around_friction needs a scene with an environment whose bodies have the same friction"},
    {"around_m_per_N", "around_m_per_N needs a scene with an environment"}};

/// Shows each live key to `changed` in the unit of messages, and writes what that makes of it.
class LiveVisitor final : public Visitor {
 public:
  using Changed = std::function<LiveValue(const LiveKey&, const LiveValue&)>;
  LiveVisitor(const Scene& scene, Changed changed)
      : scene_(scene), period_s_(scene.control_period_s), changed_(std::move(changed)) {}

 private:
  /// What does not change is not written: a rate goes through a reciprocal, which rounds.
  void number(const KeyRow& row, double& value) override {
    if (row.live.name.empty()) return;
    const bool is_time = row.dimension == Dimension::kTime;
    const bool is_rate = is_time && row.live.unit == "Hz", is_in_periods = is_time && row.live.unit == "periods";
    const double now = is_rate ? 1.0 / value : is_in_periods ? std::round(value / period_s_) : value;
    const double next = std::get<double>(changed_(row.live, now));
    if (next == now && !(is_in_periods && scene_.control_period_s != period_s_)) return;
    value = is_rate ? 1.0 / next : is_in_periods ? next * scene_.control_period_s : next;
  }
  void numbers(const KeyRow& row, Eigen::Ref<Eigen::VectorXd> values) override {
    if (!row.live.name.empty()) values = std::get<Eigen::Vector3d>(changed_(row.live, Eigen::Vector3d(values)));
  }
  void count(const KeyRow& row, Eigen::Index& value) override {
    if (row.live.name.empty()) return;
    value = std::lround(std::get<double>(changed_(row.live, static_cast<double>(value))));
  }
  std::string choice_of(const KeyRow& row, std::string_view now) override {
    if (row.live.name.empty()) return std::string(now);
    if (row.live.least == row.live.most) return std::get<std::string>(changed_(row.live, std::string(now)));
    const std::vector<std::string_view> words = words_of_choice(row.range);
    const auto place = static_cast<double>(std::ranges::find(words, now) - words.begin());
    return std::string(words.at(std::lround(std::get<double>(changed_(row.live, place)))));
  }

  const Scene& scene_;
  const double period_s_;  ///< Of control, as it is before the visit.
  const Changed changed_;
};

void visit_live(Scene& scene, const LiveVisitor::Changed& changed) {
  SceneFile file;
  file.scene = std::move(scene);
  LiveVisitor visitor(file.scene, changed);
  describe(visitor, file);
  scene = std::move(file.scene);
}

ordered_json json_of(const LiveValue& value, const LiveKey& live) {
  if (const auto* word = std::get_if<std::string>(&value)) return *word;
  if (const auto* three = std::get_if<Eigen::Vector3d>(&value)) {
    return ordered_json::array({three->x(), three->y(), three->z()});
  }
  const double number = std::get<double>(value);
  return live.whole ? ordered_json(std::lround(number)) : ordered_json(number);
}

bool is_too_coarse(double level, const LiveSettings& settings) {
  return (settings.leaves >> std::lround(level)) < kFewestControls;
}

/// Why the scene cannot have these; empty: it can.
std::string refusal_of(const LiveValues& changes, const LiveSettings& settings) {
  for (const auto& [name, words] : kNeeds) {
    const auto change = changes.find(name);
    if (change == changes.end()) continue;
    if (!settings.value(name)) return std::string(words);
    if (name == "level" && is_too_coarse(std::get<double>(change->second), settings)) {
      return "level leaves a fingertip fewer than 8 control points";
    }
  }
  for (const auto& [name, value] : changes) {
    if (!settings.value(name)) return fmt::format("this scene has no {}", name);
  }
  return "";
}

}  // namespace

std::optional<LiveValue> LiveSettings::value(std::string_view name) const {
  const auto found = values.find(name);
  return found == values.end() ? std::nullopt : std::optional(found->second);
}

double LiveSettings::number(std::string_view name) const { return std::get<double>(value(name).value()); }

bool same_fingertips(const LiveSettings& a, const LiveSettings& b) {
  return a.value("kernel") == b.value("kernel") && a.value("level") == b.value("level");
}

void copy_fingertips(const LiveSettings& from, LiveSettings& to) {
  for (const char* name : {"kernel", "level"}) {
    if (const auto value = from.value(name)) to.values.insert_or_assign(name, *value);
  }
}

LiveSettings live_settings(const Model& model) {
  LiveSettings settings;
  Scene scene = model.scene;
  visit_live(scene, [&](const LiveKey& live, const LiveValue& value) {
    return settings.values.emplace(live.name, value).first->second;
  });
  settings.friction_steps = !model.scene.task.friction.empty();
  if (!model.scene.fingertips) return settings;
  settings.values.at("level") = static_cast<double>(model.level);
  settings.leaves = model.scene.fingertips->leaves;
  return settings;
}

ordered_json settings_json(const LiveSettings& settings) {
  ordered_json json;
  for (const std::string_view name : kInEachStatus) json[std::string(name)] = nullptr;
  for (const Key& key : scene_keys()) {
    if (const auto value = settings.value(key.live.name)) json[std::string(key.live.name)] = json_of(*value, key.live);
  }
  return json;
}

ordered_json settings_list(const LiveSettings& begun) {
  ordered_json list = ordered_json::array();
  for (const Key& key : scene_keys()) {
    const LiveKey& live = key.live;
    const std::optional<LiveValue> value = begun.value(live.name);
    if (!value) continue;
    ordered_json one = {{"name", live.name}, {"key", key.path}, {"label", live.label}, {"what", key.sentence}};
    if (live.least < live.most) {
      double most = live.most;
      while (live.name == "level" && most > 0.0 && is_too_coarse(most, begun)) most -= 1;
      one.update({{"type", key.items > 1 ? "numbers" : live.whole ? "whole" : "number"}, {"unit", live.unit}});
      one.update({{"least", live.least}, {"most", most}});
    } else {
      one.update({{"type", "choice"}, {"choices", words_of(key)}});
    }
    one["default"] = json_of(*value, live);
    list.push_back(one);
  }
  return list;
}

ordered_json live_scene(const Model& model, const TriangleMesh& surface, const LiveSettings& begun) {
  ordered_json scene = scene_message(model, true, surface);
  scene["settings"] = settings_list(begun);
  return scene;
}

std::string change(const Set& set, LiveSettings& settings) {
  if (std::string refusal = refusal_of(set.changes, settings); !refusal.empty()) return refusal;
  LiveSettings changed = settings;
  for (const auto& [name, value] : set.changes) changed.values.insert_or_assign(name, value);
  if (set.changes.contains("friction")) changed.friction_steps = false;
  if (changed.number("control_Hz") > (1.0 + 1e-9) * changed.number("contact_Hz")) {
    return "control_Hz must not be more than contact_Hz";
  }
  settings = changed;
  return "";
}

LiveSettings carried_over(const LiveSettings& before, const LiveSettings& now, LiveSettings begun) {
  Set set;
  for (const auto& [name, value] : now.values) {
    // What takes the place of the task's steps may be the value that was there.
    const bool ends_steps = name == "friction" && now.friction_steps != before.friction_steps;
    if (ends_steps || before.value(name) != value) set.changes.emplace(name, value);
  }
  (void)change(set, begun);
  return begun;
}

void apply(const LiveSettings& now, const LiveSettings& settings, Scene& scene) {
  if (!settings.friction_steps) scene.task.friction.clear();
  visit_live(scene, [&](const LiveKey& live, const LiveValue& value) {
    const std::optional<LiveValue> next = settings.value(live.name);
    return next && next != now.value(live.name) ? *next : value;
  });
}

void apply(const LiveSettings& now, const LiveSettings& settings, Model& model) {
  const std::optional<int> level = model.scene.contact.level;
  apply(now, settings, model.scene);
  model.scene.contact.level = level;  // What the scene asked for; the model's own is set below.
  if (same_fingertips(settings, now)) return;
  set_fingertips(model, model.scene.fingertips->material.kernel, static_cast<int>(settings.number("level")));
}

}  // namespace thenar::window
