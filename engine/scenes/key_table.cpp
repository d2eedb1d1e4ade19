#include "engine/scenes/key_table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "engine/scenes/describe.h"

namespace thenar {

namespace {

using enum KeyKind;
using enum Dimension;

// In SI units without their names; lengths of vectors that are directions do not count.
const std::vector<Key>& hand_rows() {
  static const std::vector<Key> rows{
      {"joints", kMaps, kNone, "", "", "The joints, finger by finger, each from the palm on: up to five a finger."},
      {"joints.name", kText, kNone, "", "", "Its name."},
      {"joints.origin_at_q0", kQuantities, kNone, "-2 .. 2", "", "A point of its axis at q = 0, hand frame, in m.", 3},
      {"joints.axis_at_q0", kQuantities, kNone, "", "", "The direction of its axis at q = 0, hand frame.", 3},
      {"joints.limits", kQuantities, kNone, "-6.3 .. 6.3", "",
       "The ends of its range, in rad: a turn each way at most.", 2},
      {"joints.follows", kText, kNone, "", "(It turns by itself.)",
       "The joint of its finger, nearer to the palm, that it turns with: it has no angle of its own."},
      {"joints.ratio", kQuantity, kNone, "-100 .. 100", "1", "Its angle over that of the joint that it follows."},
      {"joints.offset", kQuantity, kNone, "-100 .. 100", "0", "What is added to that, in rad."},

      {"segments", kMaps, kNone, "", "", "The bones but for the palm."},
      {"segments.name", kText, kNone, "", "", "Its name."},
      {"segments.moved_by", kTexts, kNone, "", "", "The first joints of one finger, in their order."},
      {"segments.length", kQuantity, kNone, "0 .. 1", "", "Its length in m."},
      {"segments.mass", kQuantity, kNone, "0 .. 10", "", "Its mass in kg."},
      {"segments.com", kQuantities, kNone, "", "", "Its centre of mass, in its frame, in m.", 3},
      {"segments.frame_at_q0", kMap, kNone, "", "", "Its frame at q = 0."},
      {"segments.frame_at_q0.R", kRotation, kNone, "", "", "Its rotation."},
      {"segments.frame_at_q0.origin", kQuantities, kNone, "", "", "Its origin in m.", 3},

      {"fingertips", kMaps, kNone, "", "", "The fingertips, one a finger, in the order of the joints: up to five."},
      {"fingertips.finger", kText, kNone, "", "", "Its finger's name."},
      {"fingertips.segment", kText, kNone, "", "",
       "The last segment of its finger: its `moved_by` are the finger's joints."},
      {"fingertips.pulp_centre", kQuantities, kNone, "-2 .. 2", "", "The centre of its pulp, segment frame, in m.", 3},
      {"fingertips.radius", kQuantity, kNone, "1e-4 .. 0.1", "(Required without semi_axes.)",
       "The radius of its pulp in m: a sphere, or with a length a capsule."},
      {"fingertips.length", kQuantity, kNone, "1e-4 .. 0.2", "(Without it the pulp is no capsule.)",
       "Of a capsule: from the centre of one round end to that of the other, in m. Half of it is on either side of "
       "pulp_centre."},
      {"fingertips.semi_axes", kQuantities, kNone, "1e-4 .. 0.1", "(Without them the pulp is no ellipsoid.)",
       "Of an ellipsoid, in m: along the pulp, across it, and through it; the largest at most 4 times the least.", 3},
      {"fingertips.pulp_axes", kRotation, kNone, "",
       "(Of a capsule: its first axis is the segment's x. Of an ellipsoid: its third axis is pulp_normal, its first "
       "one "
       "x "
       "less what of it is along that.)",
       "How these axes lie in the segment frame: its columns. A capsule lies along the first."},
      {"fingertips.pulp_normal", kQuantities, kNone, "", "", "The mean outward direction of its pulp, segment frame.",
       3},
      {"fingertips.joint_viscosity", kQuantity, kNone, "> 0", "(The scene's.)",
       "The viscous damping of its joints in N m s."},
      {"fingertips.reduced_modulus", kQuantity, kNone, "> 0", "(The scene's.)", "The modulus E* of its pulp in Pa."},
      {"fingertips.poisson", kQuantity, kNone, "0 .. 0.5", "(The scene's.)", "Poisson's ratio of its pulp."},
      {"fingertips.relaxation", kQuantity, kNone, ">= 0", "(The scene's.)", "The retardation time of its pulp in s."},

      {"muscles", kMaps, kNone, "", "(Without them torques drive the joints.)", "The muscles."},
      {"muscles.name", kText, kNone, "", "", "Its name."},
      {"muscles.max_force", kQuantity, kNone, "0 .. 1e4", "", "The most force that it has, in N."},
      {"muscles.fibre_length", kQuantity, kNone, "1e-3 .. 1", "(None: it has no stiffness.)",
       "The length of its fibres at rest, in m."},
      {"muscles.tendon_stiffness", kQuantity, kNone, "> 0", "(Its tendon is rigid.)",
       "The stiffness of its tendon, in N/m."},
      {"muscles.crossings", kMaps, kNone, "", "", "Where its tendon crosses joints."},
      {"muscles.crossings.joints", kTexts, kNone, "", "", "The joints that it crosses."},
      {"muscles.crossings.share", kQuantity, kNone, "0 .. 1", "1", "The share of the muscle's force."},
      {"muscles.crossings.insertion", kMap, kNone, "", "", "Where it pulls, distal to the joints."},
      {"muscles.crossings.insertion.segment", kText, kNone, "", "", "The segment."},
      {"muscles.crossings.insertion.pos", kQuantities, kNone, "", "", "The point, segment frame, in m.", 3},
      {"muscles.crossings.pull", kOneOf, kNone, "", "", "Where it pulls to."},
      {"muscles.crossings.pull.via", kMap, kNone, "", "", "A point."},
      {"muscles.crossings.pull.via.segment", kText, kNone, "", "", "Its segment."},
      {"muscles.crossings.pull.via.pos", kQuantities, kNone, "", "", "Its place, segment frame, in m.", 3},
      {"muscles.crossings.pull.dir", kMap, kNone, "", "", "A direction."},
      {"muscles.crossings.pull.dir.segment", kText, kNone, "", "", "The segment that it turns with."},
      {"muscles.crossings.pull.dir.vec", kQuantities, kNone, "", "", "Its vector, segment frame.", 3},
  };
  return rows;
}

/// Notes the row of each key that a description shows.
class KeyTable final : public Visitor {
 public:
  std::vector<Key> keys;

  void per_joint(const KeyRow& row, Eigen::VectorXd&, Eigen::Index) override { add(row, kQuantities, kPerJoint); }
  std::string word(const KeyRow&, std::string_view) override { return ""; }
  bool chooses(std::string_view, bool) override { return true; }
  [[nodiscard]] bool when(bool) const override { return true; }
  bool is_there(std::string_view, bool) override { return true; }

 private:
  void number(const KeyRow& row, double&) override { add(row, kQuantity); }
  void numbers(const KeyRow& row, Eigen::Ref<Eigen::VectorXd> values) override {
    add(row, kQuantities, static_cast<int>(values.size()));
  }
  void count(const KeyRow& row, Eigen::Index&) override { add(row, kCount); }
  void rotation(const KeyRow& row, Eigen::Matrix3d&) override { add(row, kRotation); }
  void flag(const KeyRow& row, bool&) override { add(row, kFlag); }
  void text(const KeyRow& row, std::string&) override { add(row, kText); }
  void texts(const KeyRow& row, std::vector<std::string>&) override { add(row, kTexts); }
  void path(const KeyRow& row, std::filesystem::path&) override { add(row, kPath); }
  std::string choice_of(const KeyRow& row, std::string_view now) override {
    add(row, kChoice);
    return std::string(now);
  }
  void enter(const KeyRow& row, KeyKind kind) override {
    add(row, kind);
    maps_.emplace_back(row.name);
  }
  bool enters_map(const KeyRow& row, std::filesystem::path&) override {
    enter(row, kPath);
    return true;
  }
  std::size_t begin_list(const KeyRow& row, std::size_t) override {
    add(row, kMaps);
    return 1;
  }
  void begin_item(const KeyRow& row, std::size_t) override { maps_.emplace_back(row.name); }
  void leave() override { maps_.pop_back(); }

  void add(const KeyRow& row, KeyKind kind, int items = 1) {
    const std::string path = fmt::format("{}{}{}", fmt::join(maps_, "."), maps_.empty() ? "" : ".", row.name);
    keys.push_back({path, kind, row.dimension, row.range, row.without, row.sentence, items, row.live});
  }

  std::vector<std::string_view> maps_;
};

}  // namespace

Keys scene_keys() {
  static const std::vector<Key> keys = [] {
    KeyTable table;
    SceneFile file;
    describe(table, file);
    return table.keys;
  }();
  return keys;
}
Keys hand_keys() { return hand_rows(); }

}  // namespace thenar
