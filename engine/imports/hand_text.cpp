#include "engine/imports/hand_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace thenar {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// A name as YAML reads it back: in quotes unless it is a plain word.
std::string word(const std::string& name) {
  const auto is_plain = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-'; };
  const bool is_word = !name.empty() && std::isalpha(static_cast<unsigned char>(name.front())) != 0 &&
                       std::ranges::all_of(name, is_plain);
  std::string small = name;
  for (char& c : small) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  constexpr std::string_view kReserved[]{"null", "true", "false", "yes", "no", "on", "off"};
  if (is_word && std::ranges::find(kReserved, small) == std::end(kReserved)) return name;
  std::string quoted = "\"";
  for (const char c : name) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + '"';
}

std::string number(double value) {
  const double rounded = std::round(value * 1e12) / 1e12;
  return fmt::format("{:.13g}", rounded == 0.0 ? 0.0 : rounded);
}

std::string list(const Vector3d& v) { return fmt::format("[{}, {}, {}]", number(v.x()), number(v.y()), number(v.z())); }

std::string list(const Matrix3d& R) {
  return fmt::format("[{}, {}, {}]", list(Vector3d(R.row(0))), list(Vector3d(R.row(1))), list(Vector3d(R.row(2))));
}

std::string names(const Hand& hand, const std::vector<int>& joints) {
  std::string text;
  for (const int joint : joints) text += (text.empty() ? "" : ", ") + word(hand.joint(joint).name);
  return fmt::format("[{}]", text);
}

/// The first joints and followers of a finger from the palm on, as Hand::joint() counts them.
std::vector<int> chain_of(const Hand& hand, const Fingertip& tip, int joints, int followers) {
  std::vector<int> chain;
  int next = tip.first_follower;
  for (int j = 0; j < joints; ++j) {
    chain.push_back(tip.first_joint + j);
    for (; next < tip.first_follower + followers && hand.followers[next].after == j + 1; ++next) {
      chain.push_back(static_cast<int>(hand.joints.size()) + next);
    }
  }
  return chain;
}

std::string joint_text(const Hand& hand, int index) {
  const Joint& joint = hand.joint(index);
  std::string text =
      fmt::format("- {{name: {}, origin_at_q0: {}, axis_at_q0: {}, limits: [{}, {}]", word(joint.name),
                  list(joint.origin_m), list(joint.axis), number(joint.lower_rad), number(joint.upper_rad));
  if (index >= std::ssize(hand.joints)) {
    const Follower& follower = hand.followers[index - hand.joints.size()];
    text += fmt::format(", follows: {}, ratio: {}", word(hand.joints[follower.leader].name), number(follower.ratio));
    if (follower.offset_rad != 0.0) text += fmt::format(", offset: {}", number(follower.offset_rad));
  }
  return text + "}\n";
}

std::string pulp_text(const Fingertip& tip) {
  if (!tip.shape) return fmt::format("radius: {}", number(tip.radius_m));
  const std::string axes = fmt::format("pulp_axes: {}", list(tip.shape->axes));
  if (tip.shape->form == PulpShape::Form::kEllipsoid) {
    return fmt::format("semi_axes: {}, {}", list(tip.shape->half_m), axes);
  }
  return fmt::format("radius: {}, length: {}, {}", number(tip.radius_m), number(2.0 * tip.shape->half_m[0]), axes);
}

std::string crossing_text(const Hand& hand, const MuscleCrossing& crossing) {
  const auto segment = [&](int s) { return word(hand.segments[s].name); };
  const std::string share = crossing.share == 1.0 ? "" : fmt::format("share: {}, ", number(crossing.share));
  return fmt::format(
      "  - {{joints: {}, {}insertion: {{segment: {}, pos: {}}}, pull: {{{}: {{segment: {}, {}: {}}}}}}}\n",
      names(hand, crossing.joints), share, segment(crossing.insertion_segment), list(crossing.insertion_m),
      crossing.pull_is_point ? "via" : "dir", segment(crossing.pull_segment), crossing.pull_is_point ? "pos" : "vec",
      list(crossing.pull));
}

}  // namespace

std::string hand_text(const ImportedHand& made, const std::string& origin) {
  const Hand& hand = made.hand;
  std::string text =
      fmt::format("# {}\n# SI units: m, rad, kg, N. What is at_q0 is in the hand frame, all joints at 0.\n", origin);
  for (const std::string& note : made.notes) text += fmt::format("# - {}\n", note);
  text += "joints:\n";
  for (const Fingertip& tip : hand.fingertips) {
    for (const int joint : chain_of(hand, tip, tip.joints, tip.followers)) text += joint_text(hand, joint);
  }
  text += "segments:  # x to the next joint or the pulp, z along a joint's axis\n";
  for (std::size_t s = 1; s < hand.segments.size(); ++s) {
    const Segment& segment = hand.segments[s];
    text +=
        fmt::format("- {{name: {}, moved_by: {}, length: {}, mass: {}, com: {}, frame_at_q0: {{origin: {}, R: {}}}}}\n",
                    word(segment.name),
                    names(hand, chain_of(hand, hand.fingertips[segment.finger], segment.joints, segment.followers)),
                    number(segment.length_m), number(segment.mass_kg), list(segment.com_m),
                    list(Vector3d(segment.X_WS_0.translation())), list(Matrix3d(segment.X_WS_0.linear())));
  }
  const bool spheres = std::ranges::all_of(hand.fingertips, [](const Fingertip& tip) { return !tip.shape; });
  text += fmt::format("fingertips:  # pulp{}, in the frame of its segment\n", spheres ? " as a sphere" : "");
  for (const Fingertip& tip : hand.fingertips) {
    text += fmt::format("- {{finger: {}, segment: {}, pulp_centre: {}, {}, pulp_normal: {}}}\n", word(tip.finger),
                        word(hand.segments[tip.segment].name), list(tip.centre_m), pulp_text(tip), list(tip.normal));
  }
  if (hand.muscles.empty()) return text;
  text += "muscles:\n";
  for (std::size_t m = 0; m < hand.muscles.size(); ++m) {
    const Muscle& muscle = hand.muscles[m];
    text += fmt::format("- name: {}\n", word(muscle.name));
    if (!made.muscle_notes[m].empty()) text += fmt::format("  # {}\n", made.muscle_notes[m]);
    text += fmt::format("  max_force: {}\n", number(muscle.max_force_N));
    if (muscle.fibre_m) text += fmt::format("  fibre_length: {}\n", number(*muscle.fibre_m));
    if (std::isfinite(muscle.tendon_N_per_m))
      text += fmt::format("  tendon_stiffness: {}\n", number(muscle.tendon_N_per_m));
    text += "  crossings:\n";
    for (const MuscleCrossing& crossing : muscle.crossings) text += crossing_text(hand, crossing);
  }
  return text;
}

}  // namespace thenar
