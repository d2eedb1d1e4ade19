// SPDX-License-Identifier: Apache-2.0
#include "engine/stiffness/stiffness_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "engine/results/grasp_monitor.h"

namespace thenar {

using Eigen::Index;
using Eigen::Vector3d;
using nlohmann::ordered_json;

namespace {

constexpr std::array kMotions = {"along x", "along y", "along z", "about x", "about y", "about z"};
constexpr std::size_t kModesShown = 5;
constexpr double kTrusted = 0.02;  // Error of compliances to which predictions and measurements agree.

std::string vector_text(const Vector3d& v) { return fmt::format("[{:.2f}, {:.2f}, {:.2f}]", v.x(), v.y(), v.z()); }

/// Returns "the object turns about [0.98, 0.10, -0.17]".
std::string in_words(const Hand& hand, const GraspMode& mode) {
  if (mode.moving == Moving::kFinger)
    return fmt::format("the {} changes its posture", hand.fingertips[mode.finger].finger);
  return fmt::format("the object {} {}", mode.moving == Moving::kTranslation ? "moves along" : "turns about",
                     vector_text(mode.axis_O));
}

std::string time_text(double rate_per_s) {
  const double time_s = 1.0 / std::abs(rate_per_s);
  return time_s < 1.0 ? fmt::format("{:.3g} ms", 1e3 * time_s) : fmt::format("{:.3g} s", time_s);
}

/// Formats predicted, measured, and the ratio of the second to the first.
std::string cells(double predicted, const std::optional<double>& measured) {
  if (!measured) return fmt::format("{:>11.4g} {:>11} {:>8}", predicted, "-", "-");
  return fmt::format("{:>11.4g} {:>11.4g} {:>8.4g}", predicted, *measured, *measured / predicted);
}

std::string matrix_text(const StiffnessStudy& study) {
  const Matrix6d& K = study.predicted.K_O;
  const Matrix6d C = K.inverse();
  std::string text = fmt::format("\n  {:<20}{:>32}{:>34}\n", "", "all other motions held", "all other motions free");
  text += fmt::format("  {:<20}{:>11} {:>11} {:>8}  {:>11} {:>11} {:>8}\n", "about its origin", "predicted", "measured",
                      "ratio", "predicted", "measured", "ratio");
  for (Index i = 0; i < 6; ++i) {
    std::optional<double> held, free;
    if (study.measured) {
      held = study.measured->K_O(i, i);
      free = 1.0 / study.measured->C_O(i, i);
    }
    text += fmt::format("  {:<10}{:<10}{}  {}\n", kMotions[i], i < 3 ? "N/m" : "N m/rad", cells(K(i, i), held),
                        cells(1.0 / C(i, i), free));
  }
  return text;
}

std::string centred_text(const char* whose, const CentredStiffness& all) {
  std::string text = fmt::format("  {:<12}", whose);
  text += all.has_centre ? fmt::format("{:<27}", vector_text(1e3 * all.centre_m) + " mm")
                         : fmt::format("{:<27}", "none: about the origin");
  const auto values = [](const Vector3d& v) { return fmt::format("{:.4g}, {:.4g}, {:.4g}", v.x(), v.y(), v.z()); };
  return text + fmt::format("{:<26}{}\n", values(all.translation_N_per_m), values(all.rotation_Nm_per_rad));
}

std::string probe_text(const StiffnessStudy& study) {
  if (!study.measured) return "";
  const MeasuredStiffness& measured = *study.measured;
  if (!measured.is_finite) return "  not measured: a contact solve failed\n";
  if (study.acting == Acting::kControl) {
    return fmt::format(
        "  measured {:.3g} s after the push: later the law's integrals, where it has some, bring it back\n",
        measured.waited_s);
  }
  std::string text = fmt::format("  the compliances differ by {:.2g} % at most\n",
                                 100.0 * compliance_error(measured.C_O, study.predicted.K_O.inverse()));
  text += fmt::format(
      "  measured after {:.3g} s, when {:.2g} % of the slowest motion was still to come; meanwhile the object went\n"
      "  {:.3g} mm by itself\n",
      measured.waited_s, 100.0 * measured.moving, 1e3 * measured.drift_m);
  return text;
}

/// Says how the grasp came to rest, and where the prediction is not to be trusted.
std::string doubts_text(const StiffnessStudy& study) {
  const PredictedStiffness& predicted = study.predicted;
  std::string text;
  if (study.rest && predicted.is_stable()) {
    text += fmt::format(
        "  at rest, {:.3g} mm from where the object was when excitations stopped: its compliances are {:.2g} % other\n",
        1e3 * study.rest->moved_m, 100.0 * study.rest->changed);
    if (!study.rest->reached)
      text += "  not to be trusted: the object still moves, and the figures are of several states\n";
  }
  if (predicted.uncertain > kTrusted) {
    text += fmt::format("  not to be trusted beyond {:.2g} %: of the contacts {} slide or nearly do\n",
                        100.0 * predicted.uncertain, predicted.near_sliding);
  }
  return text;
}

std::string modes_text(const Hand& hand, const StiffnessStudy& study) {
  std::string text = "\nhow the whole grasp comes back, if excitations stay\n";
  const std::vector<GraspMode>& modes = study.predicted.modes;
  for (std::size_t i = 0; i < std::min(kModesShown, modes.size()); ++i) {
    const GraspMode& mode = modes[i];
    text += fmt::format("  {:>10.4g} 1/s  {}: {}{} {}\n", mode.rate_per_s, in_words(hand, mode),
                        mode.rate_per_s > 0.0 ? "comes back" : "turns away",
                        mode.swings_rad_per_s > 0.0 ? ", swinging," : "", "within " + time_text(mode.rate_per_s));
  }
  if (study.slowest_per_s) {
    text += fmt::format("  the first of them measured: {:.4g} 1/s, {:.3f} of the predicted\n", *study.slowest_per_s,
                        *study.slowest_per_s / modes.front().rate_per_s);
  }
  for (int k = 0; k < hand.fingers(); ++k) {
    if (const double least = study.predicted.joints_Nm_per_rad[k]; !(least > 0.0)) {
      text +=
          fmt::format("  with the object clamped, the {} would turn away: its joints have {:.3g} N m/rad at least\n",
                      hand.fingertips[k].finger, least);
    }
  }
  return text;
}

std::string end_text(const Hand& hand, const StiffEnd& end, const std::string& most) {
  if (!end.most) return "none: " + end_in_words(hand, end.beyond);
  return fmt::format("up to {}, {:g} of it with {:.4g} N of muscles; {}", most, kNearEnd, end.near->sum_N(),
                     end_in_words(hand, end.beyond));
}

ordered_json to_json(const Matrix6d& M) {
  ordered_json rows = ordered_json::array();
  for (Index i = 0; i < 6; ++i) {
    ordered_json row = ordered_json::array();
    for (Index j = 0; j < 6; ++j) row.push_back(M(i, j));
    rows.push_back(row);
  }
  return rows;
}

ordered_json to_json(const Vector3d& v) { return {v.x(), v.y(), v.z()}; }

ordered_json to_json(const CentredStiffness& all) {
  const auto columns = [](const Eigen::Matrix3d& axes) -> ordered_json {
    return {to_json(Vector3d(axes.col(0))), to_json(Vector3d(axes.col(1))), to_json(Vector3d(axes.col(2)))};
  };
  return {{"centre_m", all.has_centre ? to_json(all.centre_m) : ordered_json(nullptr)},
          {"translation_N_per_m", to_json(all.translation_N_per_m)},
          {"translation_axes", columns(all.translation_axes)},
          {"rotation_Nm_per_rad", to_json(all.rotation_Nm_per_rad)},
          {"rotation_axes", columns(all.rotation_axes)}};
}

ordered_json to_json(const Hand& hand, const GraspMode& mode) {
  ordered_json json{{"rate_per_s", mode.rate_per_s},
                    {"swings_rad_per_s", mode.swings_rad_per_s},
                    {"moves", mode.moving == Moving::kFinger        ? hand.fingertips[mode.finger].finger
                              : mode.moving == Moving::kTranslation ? "object, translation"
                                                                    : "object, rotation"},
                    {"share", mode.share}};
  json["axis"] = mode.moving == Moving::kFinger ? ordered_json(nullptr) : to_json(mode.axis_O);
  return json;
}

ordered_json to_json(const Hand& hand, const StiffnessReport& beyond) {
  return {{"motion", !beyond.axis_O   ? "posture"
                     : beyond.rotates ? "rotation"
                                      : "translation"},
          {"axis", beyond.axis_O ? to_json(*beyond.axis_O) : ordered_json(nullptr)},
          {"lacking", beyond.lacking},
          {"at_limit", muscle_names(hand, beyond.at_limit)}};
}

ordered_json to_json(const std::optional<StiffForces>& forces) {
  if (!forces) return nullptr;
  return {{"asked", forces->asked},
          {"sum_N", forces->sum_N()},
          {"effort_N", forces->effort_N()},
          {"forces_N", std::vector<double>(forces->forces_N.begin(), forces->forces_N.end())},
          {"stable", forces->is_stable()},
          {"K", forces->K_object ? to_json(*forces->K_object) : ordered_json(nullptr)}};
}

ordered_json to_json(const Hand& hand, const StiffEnd& end) {
  return {{"most", end.most ? ordered_json(end.most->asked) : ordered_json(nullptr)},
          {"near", to_json(end.near)},
          {"beyond", to_json(hand, end.beyond)}};
}

}  // namespace

std::string end_in_words(const Hand& hand, const StiffnessReport& beyond) {
  std::string words = "a finger's posture";
  if (const auto& axis = beyond.axis_O) {
    words = fmt::format("{} ({:.2f}, {:.2f}, {:.2f})", beyond.rotates ? "rotation about" : "translation along",
                        axis->x(), axis->y(), axis->z());
  }
  const std::vector<std::string> muscles = muscle_names(hand, beyond.at_limit);
  words += " ends it";
  return muscles.empty() ? words : fmt::format("{}, with {} at their limits", words, fmt::join(muscles, ", "));
}

std::vector<std::string> range_lines(const Hand& hand, const StiffnessRange& range) {
  const auto value = [](const StiffEnd& end) { return end.most ? end.most->asked : 0.0; };
  std::vector<std::string> lines;
  lines.push_back(!range.least ? "none hold it within their limits"
                               : fmt::format("the least are {:.4g} N, and the object {}", range.least->sum_N(),
                                             range.least->is_stable() ? "stands" : "turns away by itself"));
  lines.push_back("along all directions " +
                  end_text(hand, range.translation, fmt::format("{:.3g} N/m", value(range.translation))));
  lines.push_back("about all axes " +
                  end_text(hand, range.rotation, fmt::format("{:.3g} N m/rad", value(range.rotation))));
  if (!range.asks) return lines;
  lines.push_back("of what the scene asks for " +
                  end_text(hand, range.scene, fmt::format("{:.3g} times as much", value(range.scene))));
  if (value(range.scene) < 1.0) {
    lines.push_back("the scene asks for more than there is: " + lack_in_words(hand, range.lack));
  }
  return lines;
}

ordered_json range_json(const Hand& hand, const StiffnessRange& range) {
  ordered_json front = ordered_json::array();
  for (const StiffForces& forces : range.front) front.push_back(to_json(std::optional(forces)));
  return {{"at_s", range.at_s},
          {"least", to_json(range.least)},
          {"translation_N_per_m", to_json(hand, range.translation)},
          {"rotation_Nm_per_rad", to_json(hand, range.rotation)},
          {"of_scene", to_json(hand, range.scene)},
          {"asks", range.asks},
          {"lack", range.lack.is_infeasible ? to_json(hand, range.lack) : ordered_json(nullptr)},
          {"front", front}};
}

std::string stiffness_text(const Scene& scene, const StiffnessStudy& study) {
  const PredictedStiffness& predicted = study.predicted;
  const Hand& hand = scene.hand;
  std::string text = fmt::format("{}: the object's stiffness at {:g} s, {}\n", scene.name, study.at_s,
                                 study.acting == Acting::kMuscles
                                     ? "excitations of muscles as they are then"
                                     : "predicted for the muscles alone, measured while the control law goes on");
  if (predicted.contacts == 0) return text + "  no finger holds the object\n";
  text += fmt::format("  contacts        {} bear load, {} of them slide{}\n", predicted.contacts, predicted.sliding,
                      predicted.sliding > 0 ? ", under pushes one way, and stick under the opposite ones" : "");
  text +=
      fmt::format("  muscle forces   {:.4g} N in all; {} has {:.3g} % of its largest force, the largest share\n",
                  predicted.effort.sum_N, hand.muscles[predicted.effort.largest].name, 100.0 * predicted.effort.share);
  text += doubts_text(study) + matrix_text(study) + probe_text(study);
  if (study.acting == Acting::kMuscles && !study.measured && study.slowest_per_s) {
    text += "  not measured, for a motion turns away: there is no rest\n";
  }
  text += fmt::format("\n  {:<12}{:<27}{:<26}{}\n", "", "centre of compliance", "translation N/m",
                      "rotation about it N m/rad");
  text += centred_text("predicted", centred(predicted.K_O));
  if (study.measured) text += centred_text("measured", centred(study.measured->K_O));
  text += modes_text(hand, study);
  if (!study.range) return text;
  text += "\nwhat muscles could make of it, the torques, contacts and squeeze as they are\n";
  for (const std::string& line : range_lines(hand, *study.range)) text += "  " + line + "\n";
  return text;
}

ordered_json stiffness_json(const Scene& scene, const StiffnessStudy& study) {
  const PredictedStiffness& predicted = study.predicted;
  const Hand& hand = scene.hand;
  ordered_json joints, modes = ordered_json::array();
  for (int k = 0; k < hand.fingers(); ++k) joints[hand.fingertips[k].finger] = predicted.joints_Nm_per_rad[k];
  for (const GraspMode& mode : predicted.modes) modes.push_back(to_json(hand, mode));
  ordered_json json{{"scene", scene.name},
                    {"at_s", study.at_s},
                    {"free", study.acting == Acting::kMuscles ? "muscles" : "control"},
                    {"contacts", predicted.contacts},
                    {"sliding", predicted.sliding},
                    {"near_sliding", predicted.near_sliding},
                    {"uncertain", predicted.uncertain},
                    {"rest", nullptr},
                    {"muscles",
                     {{"sum_N", predicted.effort.sum_N},
                      {"largest", hand.muscles[predicted.effort.largest].name},
                      {"largest_share", predicted.effort.share}}},
                    {"predicted", {{"K", to_json(predicted.K_O)}, {"centred", to_json(centred(predicted.K_O))}}},
                    {"joints_least_Nm_per_rad", joints},
                    {"stable", predicted.is_stable()},
                    {"modes", modes},
                    {"measured", nullptr},
                    {"slowest_measured_per_s", nullptr},
                    {"range", study.range ? range_json(hand, *study.range) : ordered_json(nullptr)}};
  if (const auto& rest = study.rest) {
    json["rest"] = {{"reached", rest->reached}, {"moved_m", rest->moved_m}, {"changed", rest->changed}};
  }
  if (study.slowest_per_s) json["slowest_measured_per_s"] = *study.slowest_per_s;
  if (!study.measured) return json;
  const MeasuredStiffness& measured = *study.measured;
  json["measured"] = {{"K", to_json(measured.K_O)},
                      {"compliance", to_json(measured.C_O)},
                      {"centred", to_json(centred(measured.K_O))},
                      {"compliance_error", compliance_error(measured.C_O, predicted.K_O.inverse())},
                      {"waited_s", measured.waited_s},
                      {"moving", measured.moving},
                      {"drift_m", measured.drift_m},
                      {"finite", measured.is_finite}};
  return json;
}

}  // namespace thenar
