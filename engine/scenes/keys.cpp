#include "engine/scenes/keys.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <stdexcept>

#include "engine/formats/text.h"
#include "engine/scenes/describe.h"

namespace thenar {

namespace {

using enum KeyKind;
using enum Dimension;

// In SI units without their names; lengths of vectors that are directions do not count.
const std::array kHandKeys = std::to_array<Key>({
    {"joints", kMaps, kNone, "", "", "The joints, finger by finger, each from the palm on: up to five a finger."},
    {"joints.name", kText, kNone, "", "", "Its name."},
    {"joints.origin_at_q0", kQuantities, kNone, "-2 .. 2", "", "A point of its axis at q = 0, hand frame, in m.", 3},
    {"joints.axis_at_q0", kQuantities, kNone, "", "", "The direction of its axis at q = 0, hand frame.", 3},
    {"joints.limits", kQuantities, kNone, "-6.3 .. 6.3", "", "The ends of its range, in rad: a turn each way at most.",
     2},
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
     "(Of a capsule: its first axis is the segment's x. Of an ellipsoid: its third axis is pulp_normal, its first one "
     "x "
     "less what of it is along that.)",
     "How these axes lie in the segment frame: its columns. A capsule lies along the first."},
    {"fingertips.pulp_normal", kQuantities, kNone, "", "", "The mean outward direction of its pulp, segment frame.", 3},
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
});

/// The parts between separators.
std::vector<std::string_view> split(std::string_view text, std::string_view separator) {
  std::vector<std::string_view> parts;
  for (;;) {
    const std::size_t end = text.find(separator);
    parts.push_back(text.substr(0, end));
    if (end == text.npos) return parts;
    text.remove_prefix(end + separator.size());
  }
}

double bound(const Key& key, std::string_view text) {
  const bool is_zero = text == "0";  // of any unit
  const Quantity quantity = is_zero ? Quantity{} : read_quantity(text, key.dimension);
  if (!quantity.fault.empty()) throw std::logic_error(fmt::format("range of {}: {}", key.path, quantity.fault));
  return quantity.value;
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
Keys hand_keys() {
  static const std::vector<Key> keys(kHandKeys.begin(), kHandKeys.end());
  return keys;
}

const Key* find_key(Keys keys, std::string_view path) {
  const auto found = std::ranges::find(keys, path, &Key::path);
  return found == keys.end() ? nullptr : &*found;
}

const Key* find_live_key(Keys keys, std::string_view name) {
  const auto found = std::ranges::find_if(keys, [&](const Key& key) { return !name.empty() && key.live.name == name; });
  return found == keys.end() ? nullptr : &*found;
}

std::string_view parent_of(std::string_view path) {
  const std::size_t dot = path.rfind('.');
  return dot == path.npos ? "" : path.substr(0, dot);
}

std::string_view name_of(const Key& key) { return std::string_view(key.path).substr(key.path.rfind('.') + 1); }

std::vector<const Key*> keys_below(Keys keys, std::string_view path) {
  std::vector<const Key*> below;
  for (const Key& key : keys) {
    if (parent_of(key.path) == path) below.push_back(&key);
  }
  return below;
}

std::vector<std::string_view> names_below(Keys keys, std::string_view path) {
  std::vector<std::string_view> names;
  for (const Key* key : keys_below(keys, path)) names.push_back(name_of(*key));
  return names;
}

std::string_view nearest_key(Keys keys, std::string_view path) {
  const std::string_view name = path.substr(path.rfind('.') + 1);
  const auto nearest_among = [&](const std::vector<const Key*>& candidates) -> std::string_view {
    std::vector<std::string_view> names;
    for (const Key* key : candidates) names.push_back(name_of(*key));
    const std::string_view nearest = nearest_word(name, names);
    const auto found = std::ranges::find(candidates, nearest, [](const Key* key) { return name_of(*key); });
    return nearest.empty() ? "" : (*found)->path;
  };
  const std::string_view parent = parent_of(path);
  const std::vector<const Key*> siblings = keys_below(keys, parent);
  const std::string_view sibling = nearest_among(siblings);
  if (!sibling.empty()) return sibling;
  const bool must_agree = !parent.empty() && !siblings.empty();
  std::vector<const Key*> all;
  std::vector<std::string_view> paths;
  for (const Key& key : keys) {
    if (must_agree && name_of(key) != name) continue;
    all.push_back(&key);
    paths.push_back(key.path);
  }
  const std::string_view whole = nearest_word(path, paths);
  return whole.empty() ? nearest_among(all) : whole;
}

bool has_default(const Key& key) { return !key.without.empty() && !key.without.starts_with('('); }

bool is_required(Keys keys, const Key& key) {
  const Key* const parent = find_key(keys, parent_of(key.path));
  return key.without.empty() && (parent == nullptr || parent->kind != kOneOf);
}

Range range_of(const Key& key) {
  const std::string_view text = key.kind == kChoice ? "" : split(key.range, " | ").front();
  const std::vector<std::string_view> ends = split(text, " .. ");
  Range range;
  if (ends.size() == 2) {
    range.least_text = ends[0];
    range.most_text = ends[1];
  } else if (!text.empty()) {
    range.open = text.starts_with("> ");
    if (!range.open && !text.starts_with(">= ")) throw std::logic_error(fmt::format("range of {}", key.path));
    range.least_text = text.substr(range.open ? 2 : 3);
  }
  if (!range.least_text.empty()) range.least = bound(key, range.least_text);
  if (!range.most_text.empty()) range.most = bound(key, range.most_text);
  return range;
}

std::vector<std::string_view> words_of(const Key& key) {
  std::vector<std::string_view> words = split(key.range, " | ");
  if (key.kind != kChoice) words.erase(words.begin());  // the range of numbers, which may be empty
  return words;
}

std::string range_fault(const Key& key, double value, std::string_view text) {
  const Range range = range_of(key);
  if (range.open && value <= range.least) {
    return fmt::format("{} must be greater than {}", text, range.least == 0.0 ? "zero" : range.least_text);
  }
  if (range.most_text.empty() && range.least == 0.0 && value < 0.0) return fmt::format("{} must not be negative", text);
  if (value < range.least) return fmt::format("{} must be at least {}", text, range.least_text);
  if (value > range.most) return fmt::format("{} must be at most {}", text, range.most_text);
  return "";
}

}  // namespace thenar
