// SPDX-License-Identifier: Apache-2.0
#include "engine/capacity/capacity_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace thenar {

using nlohmann::ordered_json;

namespace {

// The three-jaw chuck pinch of people, right hands, means of 135 healthy adults, 20.67 and 15.26 pounds: Stegink Jansen
// et al. 2003, J Hand Ther 16:326.
constexpr double kMen_N = 92.0, kWomen_N = 68.0;

std::string in_words(const LargestForce& force) {
  if (force.status == LimitStatus::kOptimal) return fmt::format("{:.1f}", force.force_N);
  return force.status == LimitStatus::kUnbounded ? "any" : "unknown";
}

const char* name_of(LimitStatus status) {
  if (status == LimitStatus::kOptimal) return "optimal";
  return status == LimitStatus::kUnbounded ? "unbounded" : "unproved";
}

/// Returns "PI 0.31, IL 0.27".
std::string limits_in_words(const Hand& hand, const LargestForce& force, std::size_t most) {
  std::string text;
  for (std::size_t i = 0; i < std::min(most, force.limiting.size()); ++i) {
    const LimitingMuscle& limit = force.limiting[i];
    text += fmt::format("{}{} {:.2f}", i == 0 ? "" : ", ", hand.muscles[limit.muscle].name, limit.gain);
  }
  return text;
}

/// Returns the normal force of a finger in a pinch; rounding may have either sign for one that does not press.
double normal_N(const HandGrip& grip, const LargestForce& force, int finger) {
  return std::max(0.0, force.contacts_N.col(finger).dot(grip.contacts[finger].axes.col(0)));
}

std::string pinch_text(const HandGrip& grip, const HandCapacity& capacity) {
  const Hand& hand = grip.hand;
  const LargestForce& pinch = capacity.pinch;
  std::string text = fmt::format("largest pinch, friction {:g}: {} N by the {}\n", capacity.friction, in_words(pinch),
                                 hand.fingertips[0].finger);
  if (pinch.status != LimitStatus::kOptimal) return text;
  for (int k = 0; k < hand.fingers(); ++k) {
    text += fmt::format("  {:<12}{:>8.1f} N normal{:>8.1f} N in all\n", hand.fingertips[k].finger,
                        normal_N(grip, pinch, k), pinch.contacts_N.col(k).norm());
  }
  text += fmt::format("  people, three-jaw chuck: {:.0f} N (men), {:.0f} N (women)\n", kMen_N, kWomen_N);
  if (pinch.limiting.empty()) return text + "\nno muscle limits it: the fingers cannot squeeze the object here\n";
  text += "\nmuscles at their largest force that limit it\n";
  text += fmt::format("  {:<12}{:>10}{:>18}{:>16}\n", "", "largest N", "1 N more gives N", "its share");
  for (const LimitingMuscle& limit : pinch.limiting) {
    const Muscle& muscle = hand.muscles[limit.muscle];
    text += fmt::format("  {:<12}{:>10.1f}{:>18.3f}{:>14.0f} %\n", muscle.name, muscle.max_force_N, limit.gain,
                        100.0 * limit.share);
  }
  return text;
}

std::string finger_text(const Hand& hand, const FingerCapacity& finger, const std::string& name) {
  constexpr std::size_t kNamed = 5;
  std::string text = fmt::format("\n{}, N{:>37}\n", name, "limited by (1 N more gives N)");
  const auto row = [&](const std::string& what, const LargestForce& force) {
    text += fmt::format("  {:<34}{:>8}  {}\n", what, in_words(force), limits_in_words(hand, force, kNamed));
  };
  row("along its contact's normal", finger.normal);
  row("and with friction across", finger.normal_with_friction);
  for (const PressDirection& press : finger.ring) {
    const int degrees = static_cast<int>(std::lround(press.angle_rad * 180.0 / std::numbers::pi));
    const char* what = "";
    if (degrees == 0) what = ", as its pulp faces";
    if (degrees == 90) what = ", to its tip";
    if (degrees == 180) what = ", to its back";
    if (degrees == 270) what = ", away from its tip";
    row(fmt::format("{:>3} degrees{}", degrees, what), press.largest);
  }
  row("along its last joint's axis", finger.along_axis);
  row("against that axis", finger.against_axis);
  return text;
}

ordered_json to_json(const Hand& hand, const LargestForce& force) {
  ordered_json limits = ordered_json::array();
  for (const LimitingMuscle& limit : force.limiting) {
    limits.push_back({{"muscle", hand.muscles[limit.muscle].name}, {"gain", limit.gain}, {"share", limit.share}});
  }
  if (force.status != LimitStatus::kOptimal) return {{"status", name_of(force.status)}, {"force_N", nullptr}};
  return {{"status", name_of(force.status)},
          {"force_N", force.force_N},
          {"residual", force.residual},
          {"limiting", limits}};
}

ordered_json to_json(const Hand& hand, const FingerCapacity& finger, const std::string& name) {
  ordered_json ring = ordered_json::array();
  for (const PressDirection& press : finger.ring) {
    ordered_json row{{"angle_deg", press.angle_rad * 180.0 / std::numbers::pi},
                     {"direction", {press.direction.x(), press.direction.y(), press.direction.z()}}};
    row.update(to_json(hand, press.largest));
    ring.push_back(row);
  }
  return {{"finger", name},
          {"normal", to_json(hand, finger.normal)},
          {"normal_with_friction", to_json(hand, finger.normal_with_friction)},
          {"ring", ring},
          {"along_axis", to_json(hand, finger.along_axis)},
          {"against_axis", to_json(hand, finger.against_axis)}};
}

}  // namespace

std::string capacity_text(const HandGrip& grip, const HandCapacity& capacity) {
  std::string text = pinch_text(grip, capacity);
  for (std::size_t k = 0; k < capacity.fingers.size(); ++k)
    text += finger_text(grip.hand, capacity.fingers[k], grip.hand.fingertips[k].finger);
  return text;
}

ordered_json capacity_json(const HandGrip& grip, const HandCapacity& capacity) {
  const Hand& hand = grip.hand;
  ordered_json pinch = to_json(hand, capacity.pinch);
  if (capacity.pinch.status == LimitStatus::kOptimal) {
    for (int k = 0; k < hand.fingers(); ++k)
      pinch["normal_N"][hand.fingertips[k].finger] = normal_N(grip, capacity.pinch, k);
    for (std::size_t m = 0; m < hand.muscles.size(); ++m)
      pinch["muscles_N"][hand.muscles[m].name] = capacity.pinch.muscles_N[static_cast<Eigen::Index>(m)];
  }
  ordered_json fingers = ordered_json::array();
  for (std::size_t k = 0; k < capacity.fingers.size(); ++k)
    fingers.push_back(to_json(hand, capacity.fingers[k], hand.fingertips[k].finger));
  return {{"friction", capacity.friction},
          {"pinch", pinch},
          {"people_N", {{"men", kMen_N}, {"women", kWomen_N}}},
          {"fingers", fingers}};
}

}  // namespace thenar
