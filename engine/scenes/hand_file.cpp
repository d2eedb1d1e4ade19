#include "engine/scenes/hand_file.h"

#include <algorithm>
#include <string_view>

#include "engine/scenes/config.h"
#include "engine/scenes/keys.h"

namespace thenar {

using Eigen::Vector3d;

namespace {

template <typename Named>
int index_of(const Named& items, std::string_view name) {
  const auto found = std::find_if(items.begin(), items.end(), [&](const auto& item) { return item.name == name; });
  return found == items.end() ? -1 : static_cast<int>(found - items.begin());
}

Vector3d unit3(const ConfigMap& map, std::string_view key) {
  const Vector3d v = map.quantities(key);
  if (v.squaredNorm() > 0.0) return v.normalized();
  map.refuse(key, "a direction must not be zero");
  return Vector3d::UnitX();
}

int joint_index(const Hand& hand, const ConfigMap& map, std::string_view key, std::string_view name) {
  const int index = index_of(hand.joints, name);
  if (index < 0) map.refuse(key, "no joint is named '" + std::string(name) + "'");
  return std::max(index, 0);
}

int segment_index(const Hand& hand, const ConfigMap& map) {
  const std::string name = map.text("segment");
  const int index = index_of(hand.segments, name);
  if (index < 0) map.refuse("segment", "no segment is named '" + name + "'");
  return std::max(index, 0);
}

void read_joints(const ConfigMap& root, Hand& hand) {
  const auto joints = root.list_of_maps("joints");
  if (joints.size() != kJoints) {
    root.refuse("joints", "must list " + std::to_string(kJoints) + " joints: four a finger, thumb first");
    return;
  }
  for (int i = 0; i < kJoints; ++i) {
    const Eigen::VectorXd limits = joints[i].quantities("limits");
    hand.joints[i] = {joints[i].text("name"), joints[i].quantities("origin_at_q0"), unit3(joints[i], "axis_at_q0"),
                      limits[0], limits[1]};
  }
}

/// A segment is moved by the first joints of one finger, in their order.
void read_moved_by(const Hand& hand, const ConfigMap& map, Segment& segment) {
  const auto names = map.texts("moved_by");
  segment.joints = std::min(static_cast<int>(names.size()), kJointsPerFinger);
  for (int j = 0; j < static_cast<int>(names.size()); ++j) {
    const int index = joint_index(hand, map, "moved_by", names[j]);
    if (j == 0) segment.finger = index / kJointsPerFinger;
    if (j >= kJointsPerFinger || index != segment.finger * kJointsPerFinger + j) {
      map.refuse("moved_by", "must name the first joints of one finger, in their order");
      return;
    }
  }
}

void read_segments(const ConfigMap& root, Hand& hand) {
  Segment palm;
  palm.name = "palm";
  palm.X_WS_0.setIdentity();
  hand.segments.push_back(palm);
  for (const ConfigMap& map : root.list_of_maps("segments")) {
    Segment segment;
    segment.name = map.text("name");
    read_moved_by(hand, map, segment);
    const ConfigMap frame = map.map("frame_at_q0");
    segment.X_WS_0.setIdentity();
    segment.X_WS_0.linear() = frame.rotation("R");
    segment.X_WS_0.translation() = frame.quantities("origin");
    segment.length_m = map.quantity("length");
    segment.mass_kg = map.quantity("mass");
    segment.com_m = map.quantities("com");
    hand.segments.push_back(segment);
  }
}

void read_fingertips(const ConfigMap& root, Hand& hand) {
  const auto tips = root.list_of_maps("fingertips");
  if (tips.size() != kFingers) {
    root.refuse("fingertips", "must list one fingertip for each of the " + std::to_string(kFingers) + " fingers");
    return;
  }
  for (int k = 0; k < kFingers; ++k) {
    Fingertip& tip = hand.fingertips[k];
    tip.finger = tips[k].text("finger");
    tip.segment = segment_index(hand, tips[k]);
    tip.centre_m = tips[k].quantities("pulp_centre");
    tip.radius_m = tips[k].quantity("radius");
    tip.normal = unit3(tips[k], "pulp_normal");
    const Segment& distal = hand.segments[tip.segment];
    if (distal.finger != k || distal.joints != kJointsPerFinger) {
      tips[k].refuse("segment",
                     "must be the segment that all four joints of finger " + std::to_string(k + 1) + " move");
    }
  }
}

MuscleCrossing read_crossing(const Hand& hand, const ConfigMap& map) {
  MuscleCrossing crossing;
  for (const std::string& name : map.texts("joints")) crossing.joints.push_back(joint_index(hand, map, "joints", name));
  crossing.share = map.quantity("share");
  const ConfigMap insertion = map.map("insertion");
  crossing.insertion_segment = segment_index(hand, insertion);
  crossing.insertion_m = insertion.quantities("pos");
  const ConfigMap pull = map.map("pull");
  crossing.pull_is_point = pull.one_of() == "via";
  const ConfigMap towards = pull.map(crossing.pull_is_point ? "via" : "dir");
  crossing.pull_segment = segment_index(hand, towards);
  crossing.pull = crossing.pull_is_point ? Vector3d(towards.quantities("pos")) : unit3(towards, "vec");
  return crossing;
}

}  // namespace

Hand load_hand(const std::filesystem::path& file) {
  Config config(file, hand_keys());
  const ConfigMap root = config.root();
  Hand hand;
  read_joints(root, hand);
  read_segments(root, hand);
  read_fingertips(root, hand);
  for (const ConfigMap& map : root.list_of_maps("muscles")) {
    Muscle muscle{map.text("name"), map.quantity("max_force"), {}};
    for (const ConfigMap& crossing : map.list_of_maps("crossings")) {
      muscle.crossings.push_back(read_crossing(hand, crossing));
    }
    hand.muscles.push_back(std::move(muscle));
  }
  config.finish();
  return hand;
}

}  // namespace thenar
