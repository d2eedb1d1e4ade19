// SPDX-License-Identifier: Apache-2.0
#include "engine/recordings/signal_columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <initializer_list>

#include "engine/results/tick_fields.h"

namespace thenar {

using nlohmann::ordered_json;

namespace {

/// Of recordings made before 0.8: the field's name then, and now.
constexpr std::array<std::array<std::string_view, 2>, 4> kOldNames = {{{"force_n_N", "normal_N"},
                                                                       {"force_t_N", "tangential_N"},
                                                                       {"desired_n_N", "desired_normal_N"},
                                                                       {"desired_t_N", "desired_tangential_N"}}};

constexpr TickField kUnstretchedForces{
    .name = kUnstretched, .unit = "N", .of = Of::kMuscle, .shown = "unstretched", .shown_unit = "N"};

const TickField* field_of(std::string_view name) {
  if (name == kUnstretched) return &kUnstretchedForces;
  const auto* const old = std::ranges::find(kOldNames, name, [](const auto& names) { return names[0]; });
  return tick_field(old == kOldNames.end() ? name : (*old)[1]);
}

constexpr std::array<std::string_view, 3> kAxes = {"x", "y", "z"}, kShares = {"p50", "p99", "p999"};

/// The parts that are there, with "_" between them.
std::string joined(std::initializer_list<std::string_view> parts) {
  std::string all;
  for (const std::string_view part : parts) {
    if (!part.empty()) all.append(all.empty() ? "" : "_").append(part);
  }
  return all;
}

/// Whose number i of a field is; nothing where there is no such one.
std::string_view owner_of(Of of, std::size_t i, const SignalNames& names) {
  const auto name = [i](const std::vector<std::string>& all, std::size_t numbers) {
    return i / numbers < all.size() ? std::string_view(all[i / numbers]) : std::string_view();
  };
  switch (of) {
    case Of::kFinger:
      return name(names.fingers, 1);
    case Of::kFingerAxis:
      return name(names.fingers, 3);
    case Of::kBodyAxis:
      return name(names.bodies, 3);
    case Of::kJoint:
      return name(names.joints, 1);
    case Of::kMuscle:
      return name(names.muscles, 1);
    default:
      return {};
  }
}

/// Number i of a field; without a name where there is none for it.
SignalColumn named(const TickField& field, std::size_t i, const SignalNames& names) {
  SignalColumn column{"", std::string(field.shown_unit), 0, field.factor};
  const std::string_view owner = owner_of(field.of, i, names);
  switch (field.of) {
    case Of::kFinger:
    case Of::kJoint:
    case Of::kMuscle:
      if (!owner.empty()) column.name = joined({owner, field.shown, field.shown_unit});
      break;
    case Of::kFingerAxis:
    case Of::kBodyAxis:
      if (!owner.empty()) column.name = joined({owner, field.shown, kAxes[i % 3], field.shown_unit});
      break;
    case Of::kAxis:
      if (i < 3) column.name = joined({field.shown, kAxes[i], field.shown_unit});
      break;
    case Of::kPercentile:
      if (i < 3) column.name = joined({field.shown, kShares[i], field.shown_unit});
      break;
    case Of::kPose:
      // Position, then rotation by rows.
      if (i < 3) column.name = joined({field.shown, kAxes[i], field.shown_unit});
      if (i >= 3 && i < 12) column = {fmt::format("{}_R_{}{}", field.shown, i / 3, i % 3 + 1), "", 0, 1.0};
      break;
    default:
      if (!field.shown.empty() && i == 0) column.name = joined({field.shown, field.shown_unit});
  }
  return column;
}

}  // namespace

SignalNames signal_names(const Model& model) {
  SignalNames names;
  for (const Fingertip& tip : model.scene.hand.fingertips) names.fingers.push_back(tip.finger);
  for (const Joint& joint : model.scene.hand.joints) names.joints.push_back(joint.name);
  for (const Muscle& muscle : model.scene.hand.muscles) names.muscles.push_back(muscle.name);
  if (const auto& environment = model.scene.environment) {
    for (const EnvironmentBody& body : environment->bodies) names.bodies.push_back(body.name);
  }
  return names;
}

SignalNames signal_names(const ordered_json& scene) {
  SignalNames names;
  for (const ordered_json& finger : scene.value("fingers", ordered_json::array())) {
    names.fingers.push_back(finger.at("name"));
  }
  for (const ordered_json& joint : scene.value("joints", ordered_json::array())) names.joints.push_back(joint);
  for (const ordered_json& muscle : scene.value("muscles", ordered_json::array())) {
    names.muscles.push_back(muscle.at("name"));
  }
  for (const ordered_json& body : scene.value("bodies", ordered_json::array())) {
    names.bodies.push_back(body.at("name"));
  }
  return names;
}

bool is_signal(const Field& field) {
  const TickField* known = field_of(field.name);
  return known == nullptr || known->of != Of::kShape;
}

SignalColumn signal_column(const Field& field, std::size_t i, const SignalNames& names) {
  SignalColumn column;
  if (const TickField* known = field_of(field.name)) column = named(*known, i, names);
  if (column.name.empty()) {
    column = {field.count == 1 ? field.name : fmt::format("{}[{}]", field.name, i), field.unit, 0, 1.0};
  }
  column.at = field.begin + i;
  return column;
}

std::vector<SignalColumn> signal_columns(const std::vector<Field>& fields, const SignalNames& names) {
  std::vector<SignalColumn> columns;
  for (const Field& field : fields) {
    if (!is_signal(field)) continue;
    for (std::size_t i = 0; i < field.count; ++i) columns.push_back(signal_column(field, i, names));
  }
  return columns;
}

}  // namespace thenar
