#include "engine/scenes/hand_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string_view>
#include <vector>

#include "engine/formats/files.h"
#include "engine/formats/text.h"
#include "engine/hand/coupled_joints.h"
#include "engine/scenes/config.h"
#include "engine/scenes/key_table.h"
#include "solvers/muscles/muscle_forces.h"

namespace thenar {

using Eigen::Matrix3d;
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

std::optional<double> if_named(const ConfigMap& map, std::string_view key) {
  return map.has(key) ? std::optional(map.quantity(key)) : std::nullopt;
}

/// "no joint is named 'tumb'", and the name that is nearest.
template <class Named>
std::string none_is_named(const char* thing, std::string_view name, const std::vector<Named>& all) {
  std::vector<std::string_view> names;
  for (const Named& one : all) names.push_back(one.name);
  return fmt::format("no {} is named '{}'{}", thing, name, did_you_mean(nearest_word(name, names)));
}

int joint_index(const Hand& hand, const ConfigMap& map, std::string_view key, std::string_view name) {
  const int index = index_of(hand.joints, name);
  if (index < 0) map.refuse(key, none_is_named("joint", name, hand.joints));
  return std::max(index, 0);
}

int segment_index(const Hand& hand, const ConfigMap& map) {
  const std::string name = map.text("segment");
  const int index = index_of(hand.segments, name);
  if (index < 0) map.refuse("segment", none_is_named("segment", name, hand.segments));
  return std::max(index, 0);
}

void read_joints(const ConfigMap& root, Hand& hand) {
  const auto joints = root.list_of_maps("joints");
  if (joints.size() > kMaxHandJoints) root.refuse("joints", fmt::format("must list at most {} joints", kMaxHandJoints));
  for (std::size_t i = 0; i < std::min<std::size_t>(joints.size(), kMaxHandJoints); ++i) {
    const Eigen::VectorXd limits = joints[i].quantities("limits");
    hand.joints.push_back({joints[i].text("name"), joints[i].quantities("origin_at_q0"), unit3(joints[i], "axis_at_q0"),
                           limits[0], limits[1]});
  }
}

/// The palm and the bones; returns the joints that move each.
std::vector<std::vector<int>> read_segments(const ConfigMap& root, Hand& hand) {
  Segment palm;
  palm.name = "palm";
  palm.X_WS_0.setIdentity();
  hand.segments.push_back(palm);
  std::vector<std::vector<int>> moved_by(1);
  for (const ConfigMap& map : root.list_of_maps("segments")) {
    Segment segment;
    segment.name = map.text("name");
    std::vector<int>& joints = moved_by.emplace_back();
    for (const std::string& name : map.texts("moved_by")) joints.push_back(joint_index(hand, map, "moved_by", name));
    const ConfigMap frame = map.map("frame_at_q0");
    segment.X_WS_0.setIdentity();
    segment.X_WS_0.linear() = frame.rotation("R");
    segment.X_WS_0.translation() = frame.quantities("origin");
    segment.length_m = map.quantity("length");
    segment.mass_kg = map.quantity("mass");
    segment.com_m = map.quantities("com");
    hand.segments.push_back(segment);
  }
  return moved_by;
}

/// Axes whose column `kept` is along v, and another one near w: the first to the third, or the third to the first.
Matrix3d axes_about(int kept, const Vector3d& v, const Vector3d& w) {
  Vector3d u = w - w.dot(v) * v;
  u = u.norm() > 1e-6 ? u.normalized() : v.unitOrthogonal();
  Matrix3d axes;
  axes.col(kept) = v;
  axes.col(2 - kept) = u;
  axes.col(1) = Vector3d(axes.col(2)).cross(axes.col(0));
  return axes;
}

/// The shape of a pulp: a radius is a sphere, with a length a capsule; semi-axes are an ellipsoid.
void read_pulp(const ConfigMap& map, Fingertip& tip) {
  constexpr double kMostRatio = 4.0;
  const bool has_axes = map.has("pulp_axes");
  const Matrix3d axes = has_axes ? map.rotation("pulp_axes") : Matrix3d::Identity();
  const auto set = [&](PulpShape::Form form, const Vector3d& half_m, const Matrix3d& usual) {
    tip.shape = PulpShape{form, has_axes ? axes : usual, half_m};
    tip.radius_m = tip.shape->inner_radius_m();
  };
  if (map.has("semi_axes")) {
    const Vector3d half_m = map.quantities("semi_axes");
    for (const char* const other : {"radius", "length"}) {
      if (!map.has(other)) continue;
      (void)map.quantity(other);
      map.refuse(other, "an ellipsoid has semi_axes alone: name these, or a radius");
    }
    if (half_m.maxCoeff() > kMostRatio * half_m.minCoeff()) {
      map.refuse("semi_axes", fmt::format("the largest must be at most {:g} times the least", kMostRatio));
    }
    set(PulpShape::Form::kEllipsoid, half_m, axes_about(2, tip.normal, Vector3d::UnitX()));
    return;
  }
  if (!map.has("radius")) {
    if (map.has("length")) (void)map.quantity("length");
    map.refuse("radius", "is missing: a pulp has a radius, or semi_axes");
    return;
  }
  tip.radius_m = map.quantity("radius");
  if (map.has("length")) {
    const Vector3d half_m(0.5 * map.quantity("length"), tip.radius_m, tip.radius_m);
    set(PulpShape::Form::kCapsule, half_m, axes_about(0, Vector3d::UnitX(), tip.normal));
  } else if (has_axes) {
    map.refuse("pulp_axes", "a sphere has no axes: they are of semi_axes, or of a length");
  }
}

/// A finger's joints are those that move its last segment.
void read_fingertips(const ConfigMap& root, const std::vector<std::vector<int>>& moved_by, Hand& hand) {
  const auto tips = root.list_of_maps("fingertips");
  if (tips.empty() || tips.size() > kMaxFingers) {
    if (!root.is_refused("fingertips")) {
      root.refuse("fingertips", fmt::format("must list one fingertip for each of 1 to {} fingers", kMaxFingers));
    }
    return;
  }
  int first = 0;
  bool sound = true;  // After a fault the others are read for theirs alone.
  for (const ConfigMap& map : tips) {
    Fingertip tip;
    tip.finger = map.text("finger");
    tip.segment = segment_index(hand, map);
    tip.centre_m = map.quantities("pulp_centre");
    tip.normal = unit3(map, "pulp_normal");
    read_pulp(map, tip);
    tip.joint_viscosity = if_named(map, "joint_viscosity");
    tip.reduced_modulus_Pa = if_named(map, "reduced_modulus");
    tip.poisson = if_named(map, "poisson");
    tip.relaxation_s = if_named(map, "relaxation");
    tip.first_joint = first;
    const std::vector<int>& joints = moved_by[tip.segment];
    tip.joints = static_cast<int>(std::min<std::size_t>(joints.size(), kMaxFingerJoints));
    if (!sound) continue;
    for (const int joint : joints) {
      if (joint == first) ++first;
    }
    if (joints.empty() || first != tip.first_joint + std::ssize(joints) || tip.joints != std::ssize(joints)) {
      map.refuse("segment", fmt::format("must be moved by one to {} joints: those that follow the fingers before it",
                                        kMaxFingerJoints));
      sound = false;
      continue;
    }
    const auto is_called_so = [&](const Fingertip& other) { return other.finger == tip.finger; };
    if (std::ranges::any_of(hand.fingertips, is_called_so))
      map.refuse("finger", "is there twice: '" + tip.finger + "'");
    hand.fingertips.push_back(tip);
  }
  if (!sound || first == std::ssize(hand.joints)) return;
  root.refuse("joints", "'" + hand.joints[first].name + "' moves no fingertip");
}

/// A segment is moved by the first joints of one finger, in their order.
void find_fingers(const ConfigMap& root, const std::vector<std::vector<int>>& moved_by, Hand& hand) {
  const auto maps = root.list_of_maps("segments");
  for (std::size_t s = 1; s < hand.segments.size(); ++s) {
    Segment& segment = hand.segments[s];
    segment.joints = static_cast<int>(moved_by[s].size());
    for (int j = 0; j < segment.joints; ++j) {
      const int joint = moved_by[s][j];
      for (int k = 0; j == 0 && k < hand.fingers(); ++k) {
        if (hand.fingertips[k].has_joint(joint)) segment.finger = k;
      }
      const Fingertip& tip = hand.fingertips[segment.finger];
      if (tip.has_joint(joint) && joint == tip.first_joint + j) continue;
      maps[s - 1].refuse("moved_by", "must name the first joints of one finger, in their order");
      break;
    }
  }
}

/// The joints that follow others.
std::vector<Coupling> read_couplings(const ConfigMap& root, const Hand& hand) {
  std::vector<Coupling> couplings;
  const auto maps = root.list_of_maps("joints");
  for (std::size_t i = 0; i < hand.joints.size(); ++i) {
    const ConfigMap& map = maps[i];
    if (!map.has("follows")) {
      for (const char* key : {"ratio", "offset"}) {
        if (map.has(key)) map.refuse(key, "is of a joint that follows another one: follows names that");
      }
      continue;
    }
    const Coupling coupling{static_cast<int>(i), index_of(hand.joints, map.text("follows")), map.quantity("ratio"),
                            map.quantity("offset")};
    if (coupling.leader < 0) {
      map.refuse("follows", none_is_named("joint", map.text("follows"), hand.joints));
      continue;
    }
    couplings.push_back(coupling);
    const std::string fault = coupling_fault(hand, couplings);
    if (!fault.empty()) map.refuse("follows", fault);
  }
  return couplings;
}

MuscleCrossing read_crossing(const Hand& hand, const ConfigMap& map) {
  MuscleCrossing crossing;
  for (const std::string& name : map.texts("joints")) crossing.joints.push_back(joint_index(hand, map, "joints", name));
  std::ranges::sort(crossing.joints);
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

bool is_hand_file(const std::filesystem::path& file) {
  const std::string text = "\n" + read_file(file);
  return text.find("\njoints:") != std::string::npos && text.find("\nobject:") == std::string::npos;
}

Hand load_hand(const std::filesystem::path& file) {
  const std::string text = read_file(file);
  if (const std::size_t first = text.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
      first != text.npos && text[first] == '<') {
    throw ConfigError({{printable(file.string()), "", "is XML: `thenar hand import` makes a hand of MJCF or URDF"}});
  }
  if (("\n" + text).find("\nobject:") != std::string::npos) {
    throw ConfigError({{printable(file.string()), "", "is a scene, which names its hand in hand.model, and no hand"}});
  }
  Config config(file, hand_keys());
  const ConfigMap root = config.root();
  Hand hand;
  read_joints(root, hand);
  const std::vector<std::vector<int>> moved_by = read_segments(root, hand);
  read_fingertips(root, moved_by, hand);
  if (hand.fingers() > 0 && !root.is_refused("fingertips")) find_fingers(root, moved_by, hand);
  const auto muscles = root.has("muscles") ? root.list_of_maps("muscles") : std::vector<ConfigMap>();
  if (std::ssize(muscles) > kMaxMuscles) root.refuse("muscles", fmt::format("must list at most {}", kMaxMuscles));
  for (const ConfigMap& map : muscles) {
    Muscle muscle{map.text("name"), map.quantity("max_force"), {}};
    if (map.has("fibre_length")) muscle.fibre_m = map.quantity("fibre_length");
    if (map.has("tendon_stiffness")) muscle.tendon_N_per_m = map.quantity("tendon_stiffness");
    for (const ConfigMap& crossing : map.list_of_maps("crossings")) {
      muscle.crossings.push_back(read_crossing(hand, crossing));
    }
    hand.muscles.push_back(std::move(muscle));
  }
  const std::vector<Coupling> couplings = read_couplings(root, hand);
  config.finish();
  return coupled(std::move(hand), couplings);
}

}  // namespace thenar
