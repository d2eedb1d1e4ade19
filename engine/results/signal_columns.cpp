#include "engine/results/signal_columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <initializer_list>

#include "engine/results/recording.h"

namespace thenar {

using nlohmann::ordered_json;

namespace {

/// Whose a field's numbers are.
enum class Of { kFinger, kFingerAxis, kAxis, kJoint, kMuscle, kPose, kPercentile };

/// A field of several numbers, or one in another unit than the message's. A column is named
/// <whose>_<word>_<axis>_<unit>.
struct Words {
  std::string_view field;
  Of of;
  std::string_view word, unit;
  double factor;
};

constexpr std::array kWords{
    Words{"normal_N", Of::kFinger, "normal", "N", 1.0},
    Words{"force_n_N", Of::kFinger, "normal", "N", 1.0},  // This and the next three: before 0.8.
    Words{"force_t_N", Of::kFinger, "tangential", "N", 1.0},
    Words{"desired_n_N", Of::kFinger, "desired_normal", "N", 1.0},
    Words{"desired_t_N", Of::kFinger, "desired_tangential", "N", 1.0},
    Words{"tangential_N", Of::kFinger, "tangential", "N", 1.0},
    Words{"desired_normal_N", Of::kFinger, "desired_normal", "N", 1.0},
    Words{"desired_tangential_N", Of::kFinger, "desired_tangential", "N", 1.0},
    Words{"margin", Of::kFinger, "margin", "", 1.0},
    Words{"slip_m", Of::kFinger, "slip", "um", 1e6},
    Words{"start_slip_m", Of::kFinger, "start_slip", "um", 1e6},
    Words{"spin_rad", Of::kFinger, "spin", "deg", kDegrees},
    Words{"start_spin_rad", Of::kFinger, "start_spin", "deg", kDegrees},
    Words{"sliding_share", Of::kFinger, "sliding_share", "", 1.0},
    Words{"creep_m_per_s", Of::kFinger, "creep", "um_per_s", 1e6},
    Words{"stick", Of::kFinger, "stick", "", 1.0},
    Words{"rim_friction", Of::kFinger, "rim_friction", "", 1.0},
    Words{"slip_speed_m_per_s", Of::kFinger, "slip_speed", "um_per_s", 1e6},
    Words{"torsion_Nm", Of::kFinger, "torsion", "N_mm", 1e3},
    Words{"friction_felt", Of::kFinger, "friction_felt", "", 1.0},
    Words{"squeeze_N", Of::kFinger, "squeeze", "N", 1.0},
    Words{"force_N", Of::kFingerAxis, "force", "N", 1.0},
    Words{"desired_N", Of::kFingerAxis, "desired_force", "N", 1.0},
    Words{"centre_m", Of::kFingerAxis, "centre", "mm", 1e3},
    Words{"normal", Of::kFingerAxis, "contact_normal", "", 1.0},
    Words{"position_m", Of::kAxis, "position", "mm", 1e3},
    Words{"path_target_m", Of::kAxis, "target", "mm", 1e3},
    Words{"pull_anchor_m", Of::kAxis, "pull_anchor", "mm", 1e3},
    Words{"pull_handle_m", Of::kAxis, "pull_handle", "mm", 1e3},
    Words{"pull_force_N", Of::kAxis, "pull_force", "N", 1.0},
    Words{"arm_m", Of::kAxis, "arm", "mm", 1e3},
    Words{"environment_force_N", Of::kAxis, "environment_force", "N", 1.0},
    Words{"environment_moment_Nm", Of::kAxis, "environment_moment", "N_mm", 1e3},
    Words{"q_rad", Of::kJoint, "", "rad", 1.0},
    Words{"q_m", Of::kJoint, "", "mm", 1e3},
    Words{"muscles_N", Of::kMuscle, "", "N", 1.0},
    Words{"object", Of::kPose, "object_pose", "mm", 1e3},
    Words{"target", Of::kPose, "target_pose", "mm", 1e3},
    Words{"contact_compute_us", Of::kPercentile, "contact_compute", "us", 1.0},
    Words{"contact_jitter_us", Of::kPercentile, "contact_jitter", "us", 1.0},
    Words{"control_compute_us", Of::kPercentile, "control_compute", "us", 1.0},
    Words{"control_jitter_us", Of::kPercentile, "control_jitter", "us", 1.0},
    Words{"latency_us", Of::kPercentile, "latency", "us", 1.0},
};

constexpr std::array<std::string_view, 3> kAxes = {"x", "y", "z"}, kShares = {"p50", "p99", "p999"};

/// The parts that are there, with "_" between them.
std::string joined(std::initializer_list<std::string_view> parts) {
  std::string all;
  for (const std::string_view part : parts) {
    if (!part.empty()) all.append(all.empty() ? "" : "_").append(part);
  }
  return all;
}

SignalColumn pose_column(const Words& words, std::size_t i) {
  // Position, then rotation by rows.
  if (i < 3) return {joined({words.word, kAxes[i], words.unit}), std::string(words.unit), 0, words.factor};
  return {fmt::format("{}_R_{}{}", words.word, (i - 3) / 3 + 1, (i - 3) % 3 + 1), "", 0, 1.0};
}

/// Number i of a field; without a name where there is none for it.
SignalColumn column_of(const Words& words, std::size_t i, const SignalNames& names) {
  SignalColumn column{"", std::string(words.unit), 0, words.factor};
  switch (words.of) {
    case Of::kFinger:
      if (i < names.fingers.size()) column.name = joined({names.fingers[i], words.word, words.unit});
      break;
    case Of::kFingerAxis:
      if (i / 3 < names.fingers.size()) {
        column.name = joined({names.fingers[i / 3], words.word, kAxes[i % 3], words.unit});
      }
      break;
    case Of::kAxis:
      if (i < 3) column.name = joined({words.word, kAxes[i], words.unit});
      break;
    case Of::kJoint:
      if (i < names.joints.size()) column.name = joined({names.joints[i], words.unit});
      break;
    case Of::kMuscle:
      if (i < names.muscles.size()) column.name = joined({names.muscles[i], words.unit});
      break;
    case Of::kPose:
      if (i < 12) column = pose_column(words, i);
      break;
    case Of::kPercentile:
      if (i < 3) column.name = joined({words.word, kShares[i], words.unit});
      break;
  }
  return column;
}

SignalColumn column_of(const Field& field, std::size_t i, const SignalNames& names) {
  SignalColumn column;
  const auto words = std::ranges::find(kWords, field.name, &Words::field);
  if (words != kWords.end()) column = column_of(*words, i, names);
  if (field.name == "rotation_error_rad") column = {"rotation_error_deg", "deg", 0, kDegrees};
  if (field.name == "penetration_m") column = {"penetration_um", "um", 0, 1e6};
  if (field.name == "environment_penetration_m") column = {"environment_penetration_um", "um", 0, 1e6};
  if (column.name.empty()) {
    column = {field.count == 1 ? field.name : fmt::format("{}[{}]", field.name, i), field.unit, 0, 1.0};
  }
  column.at = field.begin + i;
  return column;
}

}  // namespace

SignalNames signal_names(const Model& model) {
  SignalNames names;
  for (const Fingertip& tip : model.scene.hand.fingertips) names.fingers.push_back(tip.finger);
  for (const Joint& joint : model.scene.hand.joints) names.joints.push_back(joint.name);
  for (const Muscle& muscle : model.scene.hand.muscles) names.muscles.push_back(muscle.name);
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
  return names;
}

bool is_signal(const Field& field) {
  constexpr std::array<std::string_view, 7> kShapes = {"segments",  "displacement_m", "latency_counts", "bodies",
                                                       "touches_m", "touches_N",      "touches_margin"};
  return std::ranges::find(kShapes, field.name) == kShapes.end();
}

std::vector<SignalColumn> signal_columns(const std::vector<Field>& fields, const SignalNames& names) {
  std::vector<SignalColumn> columns;
  for (const Field& field : fields) {
    if (!is_signal(field)) continue;
    for (std::size_t i = 0; i < field.count; ++i) columns.push_back(column_of(field, i, names));
  }
  return columns;
}

}  // namespace thenar
