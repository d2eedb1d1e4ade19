// SPDX-License-Identifier: Apache-2.0
#include "engine/scenes/hand_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <mutex>
#include <optional>
#include <string_view>
#include <vector>

#include "engine/formats/files.h"
#include "engine/formats/text.h"
#include "engine/hand/coupled_joints.h"
#include "engine/scenes/config.h"
#include "engine/scenes/config_reader.h"
#include "engine/scenes/config_writer.h"
#include "engine/scenes/hand_keys.h"
#include "engine/scenes/key_table.h"
#include "solvers/muscles/muscle_forces.h"

namespace thenar {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// Makes the hand of its file's keys: names become indices. What does not fit together is refused in its place.
class HandMaker {
 public:
  HandMaker(const HandKeys& keys, const ConfigMap& root)
      : keys_(keys),
        root_(root),
        joints_(root.list_of_maps("joints")),
        segments_(root.list_of_maps("segments")),
        fingertips_(root.list_of_maps("fingertips")) {
    if (root.has("muscles")) muscles_ = root.list_of_maps("muscles");
  }

  Hand make() {
    make_joints();
    refuse_doubles("segments", segments_, keys_.segments);
    if (root_.has("muscles")) refuse_doubles("muscles", muscles_, keys_.muscles);
    // All that follows is found by these names.
    if (root_.is_refused("joints") || root_.is_refused("segments")) return std::move(hand_);
    make_segments();
    make_fingertips();
    if (hand_.fingers() > 0 && !root_.is_refused("fingertips")) find_fingers();
    if (std::ssize(keys_.muscles) > kMaxMuscles) refuse("muscles", fmt::format("must list at most {}", kMaxMuscles));
    for (std::size_t m = 0; m < keys_.muscles.size(); ++m) hand_.muscles.push_back(muscle(m));
    couple();
    return std::move(hand_);
  }
  [[nodiscard]] const std::vector<Coupling>& couplings() const { return couplings_; }

 private:
  void refuse(const char* key, const std::string& what) const {
    if (!root_.is_refused(key)) root_.refuse(key, what);
  }

  template <typename Named>
  static int index_of(const std::vector<Named>& all, std::string_view name) {
    const auto found = std::ranges::find(all, name, &Named::name);
    return found == all.end() ? -1 : static_cast<int>(found - all.begin());
  }
  /// "no joint is named 'tumb'", and the name that is nearest.
  template <typename Named>
  static std::string none_is_named(const char* thing, std::string_view name, const std::vector<Named>& all) {
    std::vector<std::string_view> names;
    for (const Named& one : all) names.push_back(one.name);
    return fmt::format("no {} is named '{}'{}", thing, name, did_you_mean(nearest_word(name, names)));
  }
  /// Those of these names, and the first one where there is none, which is refused.
  [[nodiscard]] std::vector<int> joints_named(const std::vector<std::string>& names, const ConfigMap& map,
                                              const char* key) const {
    std::vector<int> joints;
    for (const std::string& name : names) {
      const int joint = index_of(hand_.joints, name);
      if (joint < 0) map.refuse(key, none_is_named("joint", name, hand_.joints));
      joints.push_back(std::max(joint, 0));
    }
    return joints;
  }
  [[nodiscard]] int segment_named(const std::string& name, const ConfigMap& map) const {
    const int segment = index_of(hand_.segments, name);
    if (segment < 0) map.refuse("segment", none_is_named("segment", name, hand_.segments));
    return std::max(segment, 0);
  }

  /// Refuses names that are there twice.
  template <typename Named>
  void refuse_doubles(const char* list, const std::vector<ConfigMap>& maps, const std::vector<Named>& all) const {
    for (std::size_t i = 0; i < all.size(); ++i) {
      const auto is_called_so = [&](const Named& other) { return other.name == all[i].name; };
      if (std::none_of(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(i), is_called_so)) continue;
      if (!root_.is_refused(list)) maps[i].refuse("name", "is there twice: '" + all[i].name + "'");
    }
  }

  void make_joints() {
    const std::vector<JointKeys>& joints = keys_.joints;
    refuse_doubles("joints", joints_, joints);
    if (joints.size() > kMaxHandJoints) refuse("joints", fmt::format("must list at most {} joints", kMaxHandJoints));
    for (std::size_t i = 0; i < std::min<std::size_t>(joints.size(), kMaxHandJoints); ++i) {
      const JointKeys& joint = joints[i];
      if (joint.limits_rad[0] > joint.limits_rad[1]) {
        joints_[i].refuse("limits", "its lower end comes first, and must not be above the other");
      }
      hand_.joints.push_back({joint.name, joint.origin_m, joint.axis, joint.limits_rad[0], joint.limits_rad[1]});
    }
  }

  /// The palm and the bones.
  void make_segments() {
    Segment palm;
    palm.name = "palm";
    palm.X_WS_0.setIdentity();
    hand_.segments.push_back(palm);
    moved_by_.emplace_back();
    for (std::size_t s = 0; s < keys_.segments.size(); ++s) {
      const SegmentKeys& keys = keys_.segments[s];
      moved_by_.push_back(joints_named(keys.moved_by, segments_[s], "moved_by"));
      Segment segment;
      segment.name = keys.name;
      segment.X_WS_0 = keys.X_WS_0;
      segment.length_m = keys.length_m;
      segment.mass_kg = keys.mass_kg;
      segment.com_m = keys.com_m;
      hand_.segments.push_back(segment);
    }
  }

  /// Axes whose column `kept` is along v, and another one near w: the first to the third, or the third to the first.
  static Matrix3d axes_about(int kept, const Vector3d& v, const Vector3d& w) {
    Vector3d u = w - w.dot(v) * v;
    u = u.norm() > 1e-6 ? u.normalized() : v.unitOrthogonal();
    Matrix3d axes;
    axes.col(kept) = v;
    axes.col(2 - kept) = u;
    axes.col(1) = Vector3d(axes.col(2)).cross(axes.col(0));
    return axes;
  }

  /// The shape of a pulp: a radius is a sphere, with a length a capsule; semi-axes are an ellipsoid.
  static Fingertip with_pulp(const FingertipKeys& keys) {
    Fingertip tip;
    tip.finger = keys.finger;
    tip.centre_m = keys.centre_m;
    tip.normal = keys.normal;
    tip.joint_viscosity = keys.joint_viscosity;
    tip.reduced_modulus_Pa = keys.reduced_modulus_Pa;
    tip.poisson = keys.poisson;
    tip.relaxation_s = keys.relaxation_s;
    tip.radius_m = keys.radius_m.value_or(0.0);
    if (keys.semi_axes_m) {
      const Matrix3d axes = keys.axes ? *keys.axes : axes_about(2, tip.normal, Vector3d::UnitX());
      tip.shape = PulpShape{PulpShape::Form::kEllipsoid, axes, *keys.semi_axes_m};
    } else if (keys.length_m) {
      const Matrix3d axes = keys.axes ? *keys.axes : axes_about(0, Vector3d::UnitX(), tip.normal);
      tip.shape = PulpShape{PulpShape::Form::kCapsule, axes, {0.5 * *keys.length_m, tip.radius_m, tip.radius_m}};
    }
    if (tip.shape) tip.radius_m = tip.shape->inner_radius_m();
    return tip;
  }

  /// A finger's joints are those that move its last segment.
  void make_fingertips() {
    if (keys_.fingertips.empty() || keys_.fingertips.size() > kMaxFingers) {
      return refuse("fingertips", fmt::format("must list one fingertip for each of 1 to {} fingers", kMaxFingers));
    }
    int first = 0;
    bool is_sound = true;  // After a fault the others are looked at for theirs alone.
    for (std::size_t k = 0; k < keys_.fingertips.size(); ++k) {
      const ConfigMap& map = fingertips_[k];
      Fingertip tip = with_pulp(keys_.fingertips[k]);
      tip.segment = segment_named(keys_.fingertips[k].segment, map);
      tip.first_joint = first;
      const std::vector<int>& joints = moved_by_[tip.segment];
      tip.joints = static_cast<int>(std::min<std::size_t>(joints.size(), kMaxFingerJoints));
      if (!is_sound) continue;
      for (const int joint : joints) first += joint == first ? 1 : 0;
      if (joints.empty() || first != tip.first_joint + std::ssize(joints) || tip.joints != std::ssize(joints)) {
        map.refuse("segment", fmt::format("must be moved by one to {} joints: those that follow the fingers before it",
                                          kMaxFingerJoints));
        is_sound = false;
        continue;
      }
      const auto is_called_so = [&](const Fingertip& other) { return other.finger == tip.finger; };
      if (std::ranges::any_of(hand_.fingertips, is_called_so))
        map.refuse("finger", "is there twice: '" + tip.finger + "'");
      hand_.fingertips.push_back(tip);
    }
    if (is_sound && first < std::ssize(hand_.joints)) {
      root_.refuse("joints", "'" + hand_.joints[first].name + "' moves no fingertip");
    }
  }

  /// A segment is moved by the first joints of one finger, in their order.
  void find_fingers() {
    for (std::size_t s = 1; s < hand_.segments.size(); ++s) {
      Segment& segment = hand_.segments[s];
      segment.joints = static_cast<int>(moved_by_[s].size());
      for (int j = 0; j < segment.joints; ++j) {
        const int joint = moved_by_[s][j];
        for (int k = 0; j == 0 && k < hand_.fingers(); ++k) {
          if (hand_.fingertips[k].has_joint(joint)) segment.finger = k;
        }
        const Fingertip& tip = hand_.fingertips[segment.finger];
        if (tip.has_joint(joint) && joint == tip.first_joint + j) continue;
        segments_[s - 1].refuse("moved_by", "must name the first joints of one finger, in their order");
        break;
      }
    }
  }

  [[nodiscard]] Muscle muscle(std::size_t m) const {
    const MuscleKeys& keys = keys_.muscles[m];
    Muscle muscle{keys.name, keys.max_force_N, {}, keys.fibre_m};
    if (keys.tendon_N_per_m) muscle.tendon_N_per_m = *keys.tendon_N_per_m;
    const std::vector<ConfigMap> maps = muscles_[m].list_of_maps("crossings");
    for (std::size_t c = 0; c < maps.size(); ++c) muscle.crossings.push_back(crossing(keys.crossings[c], maps[c]));
    return muscle;
  }

  [[nodiscard]] MuscleCrossing crossing(const CrossingKeys& keys, const ConfigMap& map) const {
    MuscleCrossing crossing;
    crossing.joints = joints_named(keys.joints, map, "joints");
    crossing.share = keys.share;
    std::ranges::sort(crossing.joints);
    crossing.insertion_segment = segment_named(keys.insertion_segment, map.map("insertion"));
    crossing.insertion_m = keys.insertion_m;
    crossing.pull = keys.pull;
    crossing.pull_is_point = keys.pull_is_point;
    if (keys.pull_segment.empty()) return crossing;  // It is not known which of the two it is, and that is reported.
    crossing.pull_segment = segment_named(keys.pull_segment, map.map("pull").map(keys.pull_is_point ? "via" : "dir"));
    return crossing;
  }

  /// The joints that follow others.
  void couple() {
    for (std::size_t i = 0; i < hand_.joints.size(); ++i) {
      const JointKeys& keys = keys_.joints[i];
      if (keys.follows.empty()) continue;
      const Coupling coupling{static_cast<int>(i), index_of(hand_.joints, keys.follows), keys.ratio, keys.offset_rad};
      if (coupling.leader < 0) {
        joints_[i].refuse("follows", none_is_named("joint", keys.follows, hand_.joints));
        continue;
      }
      couplings_.push_back(coupling);
      const std::string fault = coupling_fault(hand_, couplings_);
      if (!fault.empty()) joints_[i].refuse("follows", fault);
    }
  }

  const HandKeys& keys_;
  const ConfigMap& root_;
  std::vector<ConfigMap> joints_, segments_, fingertips_, muscles_;
  Hand hand_;
  std::vector<std::vector<int>> moved_by_;  ///< The joints that move each segment.
  std::vector<Coupling> couplings_;
};

/// The hand that was read last, and from which text: scenes of a sweep, and one that is changed again and again, mostly
/// have the same, and to parse it takes longer than all else of a scene. For any number of threads.
class LastHand {
 public:
  [[nodiscard]] std::optional<Hand> of(const std::string& text) {
    const std::lock_guard lock(mutex_);
    return text == text_ ? hand_ : std::nullopt;
  }
  void keep(const std::string& text, const Hand& hand) {
    const std::lock_guard lock(mutex_);
    text_ = text;
    hand_ = hand;
  }

 private:
  std::mutex mutex_;
  std::string text_;
  std::optional<Hand> hand_;
};

}  // namespace

bool is_hand_file(const std::filesystem::path& file) {
  const std::string text = "\n" + read_file(file);
  return text.find("\njoints:") != std::string::npos && text.find("\nobject:") == std::string::npos;
}

Hand load_hand(const std::filesystem::path& file) {
  static LastHand last;
  const std::string text = read_file(file);
  if (std::optional<Hand> known = last.of(text)) return *std::move(known);
  if (const std::size_t first = text.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
      first != text.npos && text[first] == '<') {
    throw ConfigError({{printable(file.string()), "", "is XML: `thenar hand import` makes a hand of MJCF or URDF"}});
  }
  if (("\n" + text).find("\nobject:") != std::string::npos) {
    throw ConfigError({{printable(file.string()), "", "is a scene, which names its hand in hand.model, and no hand"}});
  }
  Config config(file, hand_keys(), {}, text);
  const ConfigMap root = config.root();
  HandKeys keys;
  read_config(root, [&](Visitor& v) { describe(v, keys); });
  HandMaker maker(keys, root);
  Hand hand = maker.make();
  config.finish();
  hand = coupled(std::move(hand), maker.couplings());
  last.keep(text, hand);
  return hand;
}

std::string hand_file_text(const Hand& hand) {
  HandKeys keys = keys_of(hand);
  return config_text([&](Visitor& v) { describe(v, keys); });
}

}  // namespace thenar
