// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "collision/shapes.h"
#include "engine/formats/files.h"
#include "engine/grasp/scene.h"
#include "engine/scenes/config.h"
#include "engine/scenes/hand_file.h"
#include "engine/scenes/key_table.h"
#include "engine/scenes/scene_text.h"
#include "engine/scenes/yaml_tree.h"
#include "tests/support/scenes.h"
#include "tests/support/scratch.h"

namespace thenar::keys_test {
namespace {

using Changes = std::vector<std::string>;

/// A default is a value that the key's reader takes.
void expect_good_default(const Key& key) {
  std::vector<YamlFault> faults;
  const auto value = read_yaml(std::string(key.without), 0, faults);
  ASSERT_TRUE(value && faults.empty());
  if (key.kind == KeyKind::kChoice) {
    EXPECT_EQ(std::ranges::count(words_of(key), value->text), 1);
    return;
  }
  std::vector<std::string> numbers;
  for (const auto& item : value->items) numbers.push_back(item->text);
  if (key.kind != KeyKind::kQuantities) numbers.push_back(value->text);
  EXPECT_EQ(std::ssize(numbers), key.items);
  for (const std::string& number : numbers) {
    const Quantity quantity = read_quantity(number, key.dimension);
    EXPECT_EQ(quantity.fault, "");
    EXPECT_EQ(range_fault(key, quantity.value, number), "");
  }
}

// Each key stands below one that may have keys, once, and can be shown: it has a sentence, and a range and a default
// that its reader understands.
TEST(Keys, AreWellFormed) {
  for (const Keys keys : {scene_keys(), hand_keys()}) {
    std::set<std::string_view> paths{""};
    for (const Key& key : keys) {
      SCOPED_TRACE(key.path);
      EXPECT_TRUE(paths.contains(parent_of(key.path))) << "a key stands after the one above it";
      EXPECT_TRUE(paths.insert(key.path).second) << "it is there already";
      EXPECT_TRUE(key.sentence.ends_with('.'));
      EXPECT_EQ(key.without.starts_with('('), key.without.ends_with(".)"));
      EXPECT_EQ(key.kind == KeyKind::kQuantities, key.items > 1 || key.items == kPerJoint);
      const bool is_map = key.kind == KeyKind::kMap || key.kind == KeyKind::kOneOf || key.kind == KeyKind::kMaps;
      EXPECT_TRUE(keys_below(keys, key.path).empty() != is_map || may_be_map(keys, key));
      EXPECT_TRUE(key.kind != KeyKind::kChoice || !words_of(key).empty());
      EXPECT_NO_THROW(EXPECT_LT(range_of(key).least, range_of(key).most));
      // Numbers without an end give results that are none, and say nothing of it.
      const bool is_number =
          key.kind == KeyKind::kCount || key.kind == KeyKind::kQuantity || key.kind == KeyKind::kQuantities;
      EXPECT_TRUE(!is_number || std::isfinite(range_of(key).most - range_of(key).least));
      if (has_default(key)) expect_good_default(key);
    }
  }
}

/// Adds the paths of all keys in a value, as the table has them.
void add_paths(const YamlNode& node, const std::string& path, std::set<std::string>& paths) {
  for (const auto& item : node.items) add_paths(*item, path, paths);
  for (const YamlNode::Entry& entry : node.entries) {
    const std::string below = key_path(path, entry.key);
    paths.insert(below);
    add_paths(*entry.value, below, paths);
  }
}

std::set<std::string> paths_in(const std::string& yaml, const std::string& path = "") {
  std::vector<YamlFault> faults;
  std::set<std::string> paths;
  if (const auto root = read_yaml(yaml, 0, faults)) add_paths(*root, path, paths);
  EXPECT_TRUE(faults.empty()) << yaml;
  return paths;
}

std::vector<std::string> without(Keys keys, const std::set<std::string>& paths) {
  std::vector<std::string> rest;
  for (const Key& key : keys) {
    if (!paths.contains(std::string(key.path))) rest.emplace_back(key.path);
  }
  return rest;
}

/// A scene with the hand and the object of found_carry, and with a posture.
std::filesystem::path taken_grasp() {
  Scene scene = scene_of("found_carry");
  scene.grasp.reset();
  SceneTextNotes notes;
  notes.hand = config_file("hand");
  notes.names_fingers = true;
  const std::filesystem::path file = scratch() / "grasp.yaml";
  write_file(file, scene_text(scene, notes));
  return file;
}

/// Scenes that name all keys between them, and are good.
std::vector<std::pair<std::string, Changes>> scenes_with_all_keys() {
  const auto shape = [](const std::string& text) {
    return std::pair<std::string, Changes>("minimal", {"object.shape={" + text + "}"});
  };
  const std::string interval = ", from: 0 s, over: 1 s}";
  const std::string turns[]{"{axis: [0, 0, 1], angle: 1 deg}", "{euler: [1 deg, 0 deg, 0 deg], order: zyx}",
                            "{quaternion: [1, 0, 0, 0]}"};
  const auto turned = [](const std::string& turn) {
    const std::string rotation = "rotation: " + turn + "}";
    return std::pair<std::string, Changes>(
        "resting_box",
        {"object.rotation=" + turn, "task.goal={" + rotation,
         "gravity={down: [0, 0, -1], magnitude: 9 m/s^2, frame: object}",
         "environment={frame: object, friction: 0.3, bodies: [{shape: {plane: true}, under: object, gap: 1 mm},"
         " {shape: {sphere: 1 mm}, position: [1 m, 0 m, 0 m], " +
             rotation + "]}"});
  };
  return {
      turned(turns[0]),
      turned(turns[1]),
      turned(turns[2]),
      {"found_carry", {"grasp={from: " + taken_grasp().string() + "}"}},
      {"stick", {"hand.mirror=false"}},
      {"found_carry", {}},
      {"box_wet",
       {"control.anticipation=true", "control.centre=[0 mm, 0 mm, -30 mm]",
        "control.muscles={activation: 10 ms, deactivation: 40 ms, stiffness: 23.4, range: 1 %, frozen_from: 1 s,"
        " object_stiffness: {translation: [100 N/m, 100 N/m, 100 N/m],"
        " rotation: [0.05 N*m/rad, 0.05 N*m/rad, 0.05 N*m/rad], centre: [0 mm, 0 mm, 0 mm], squeeze: 2 N}}",
        "fingertips.touch={delay: 65 ms, noise: 5 %, seed: 2}",
        "control.reflex={load_rate: 2 N/s, pulse: 0.2 s, release: 0.5 s, stick: 0.3, regulation: 5 1/s}",
        "task.push={force: [1 N, 0 N, 0 N], rise: 10 ms" + interval,
        "task.arm={along: [1, 0, 0], amplitude: 20 mm, frequency: 1 Hz" + interval}},
      {"scan_grasp",
       {"time.control_delay=1 ms", "model=auto",
        "tolerance={position: 1 mm, rotation: 1 deg, force: 5 %, moment: 10 %, margin: 0.1}", "contact.level=auto",
        "contact.force_error=5 %", "contact.distance_error=2 um", "control.grasp.cone=exact",
        "control.drive=" THENAR_TEST_DATA "/drive.csv", "fingertips.stiffening=0.5 1/N",
        "object.centre_of_mass=[1 mm, 0 mm, 0 mm]",
        "object.compliance={reduced_modulus: 1 MPa, poisson: 0.5, relaxation: 5 ms}",
        "task.push={force: [1 N, 0 N, 0 N], at: [0 mm, 0 mm, 0 mm], moment: [0 N*m, 0 N*m, 1 N*m]" + interval}},
      {"peg_assembly",
       {"task.phases=[{insert: {by: [0 mm, 0 mm, -1 mm], over: 1 s, most_force: 5 N, within: 2 s,"
        " position: {p: 300 N/m, i: 1 N/(m*s), d: 0 N*s/m}, rotation: {p: 1 N*m/rad, i: 0 N*m/(rad*s), d: 0 N*m*s},"
        " centre: [0 mm, 0 mm, 0 mm]}}, {release: {open: 1 mm, speed: 1 mm/s, within: 1 s}},"
        " {approach: {by: [0 mm, 0 mm, 1 mm], over: 1 s, within: 1 s}},"
        " {close: {press: 1 N, speed: 1 mm/s, within: 1 s}}, {load: {over: 1 s, within: 1 s}},"
        " {lift: {by: [0 mm, 0 mm, 1 mm], over: 1 s, within: 1 s}}, {move: {by: [0 mm, 0 mm, 1 mm], over: 1 s,"
        " within: 1 s}}, {place: {by: [0 mm, 0 mm, 1 mm], over: 1 s, within: 1 s}}]",
        "task.goal={position: [0 mm, 0 mm, 0 mm], rotation: [[1, 0, 0], [0, 1, 0], [0, 0, 1]],"
        " within: {distance: 1 mm, angle: 1 deg}}"}},
      {"resting_box",
       {"environment={friction: 0.3, compliance: 1 um/N, bodies: ["
        "{name: table, shape: {plane: true}, position: [0 mm, 0 mm, 0 mm]},"
        "{shape: {box: [1 mm, 2 mm, 3 mm]}, position: [0 mm, 0 mm, 0 mm], rotation: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]},"
        "{shape: {sphere: 3 mm}, position: [0 mm, 0 mm, 0 mm], friction: 0.5},"
        "{shape: {cylinder: {radius: 3 mm, length: 4 mm}}, position: [0 mm, 0 mm, 0 mm]},"
        "{shape: {hole: {diameter: 3 mm, depth: 4 mm, chamfer: 1 mm}}, position: [0 mm, 0 mm, 0 mm],"
        " move: [{by: [0 mm, 0 mm, 1 mm]" +
        interval + "]}]}"}},
      {"slides_ball",
       {"hand.slides=[{name: one, at: [31 mm, 0 mm, 0 mm], along: [-1, 0, 0], radius: 8 mm, force: 2 N, rise: 1 s,"
        " damping: 5 N*s/m, range: [-1 mm, 9 mm]}, {at: [-31 mm, 0 mm, 0 mm], along: [1, 0, 0], radius: 8 mm,"
        " spring: {stiffness: 1 N/mm, rest: 2 mm}}, {at: [0 mm, 31 mm, 0 mm], along: [0, -1, 0], radius: 8 mm,"
        " path: [{by: [0 mm, -1 mm, 0 mm], over: 1 s, profile: minimum_jerk}]}]"}},
      shape("box: [50 mm, 40 mm, 30 mm]"),
      shape("ellipsoid: [50 mm, 40 mm, 30 mm]"),
      shape("cylinder: {radius: 12 mm, length: 90 mm}"),
      shape("superquadric: {size: [24 mm, 24 mm, 90 mm], exponents: [0.3, 1]}"),
      shape("mug: {radius: 27 mm, height: 80 mm, wall: 3 mm, handle: {radius: 18 mm, thickness: 8 mm}}"),
      shape("cloud: {file: a.obj, unit: mm}"),
      shape("sphere: 26.09 mm")};
}

// A key that nobody reads is refused where a scene names it. So where all keys of the table are named by scenes that
// are taken, each has a reader; that each reader's key is in the table, the reader itself sees to.
TEST(Keys, OfTheTableAreAllReadOfScenes) {
  std::set<std::string> paths;
  for (const auto& [name, changes] : scenes_with_all_keys()) {
    EXPECT_NO_THROW((void)scene_of(name, changes)) << name;
    paths.merge(paths_in(read_file(config_file(name))));
    for (const std::string& change : changes) {
      const std::size_t equals = change.find('=');
      const std::string path = change.substr(0, equals);
      paths.insert(path);
      paths.merge(paths_in(change.substr(equals + 1), path));
    }
  }
  EXPECT_EQ(without(scene_keys(), paths), Changes{});
}

TEST(Keys, OfTheTableAreAllReadOfHands) {
  std::string text = read_file(config_file("hand"));
  const auto replace = [&](std::string_view plain, std::string_view keys) {
    text.replace(text.find(plain), plain.size(), keys);
  };
  replace("{finger: thumb,",
          "{finger: thumb, joint_viscosity: 0.04, reduced_modulus: 3e5, poisson: 0.4, relaxation: 1e-3,");
  replace("{name: I_DIP_FE,", "{name: I_DIP_FE, follows: I_PIP_FE, ratio: 0.7, offset: 0.01,");
  replace("pulp_centre: [0.01411, 0.00100, 0], radius: 0.0080,",
          "pulp_centre: [0.01411, 0.00100, 0], radius: 0.0080, length: 0.01, "
          "pulp_axes: [[0, 0, 1], [1, 0, 0], [0, 1, 0]],");
  replace("pulp_centre: [0.01513, 0.00100, 0], radius: 0.0080,",
          "pulp_centre: [0.01513, 0.00100, 0], semi_axes: [0.011, 0.008, 0.0065],");
  const std::filesystem::path file = scratch() / "hand.yaml";
  write_file(file, text);
  const Hand hand = load_hand(file);
  EXPECT_EQ(hand.followers.at(0).ratio, 0.7);
  EXPECT_EQ(hand.followers.at(0).offset_rad, 0.01);
  const Fingertip& thumb = hand.fingertips.front();
  EXPECT_EQ(thumb.joint_viscosity, 0.04);
  EXPECT_EQ(thumb.reduced_modulus_Pa, 3e5);
  EXPECT_EQ(thumb.poisson, 0.4);
  EXPECT_EQ(thumb.relaxation_s, 1e-3);
  EXPECT_EQ(without(hand_keys(), paths_in(text)), Changes{});
}

// What a program's own settings begin with is what a scene has that does not name them, to the last bit; and the
// table's ranges are those of the functions that are called with the values.
TEST(Keys, AgreeWithTheSettings) {
  const Scene scene = scene_of("minimal", {"tolerance={}"});
  const Tolerance tolerance;
  EXPECT_EQ(scene.tolerance.position_m, tolerance.position_m);
  EXPECT_EQ(scene.tolerance.rotation_rad, tolerance.rotation_rad);
  EXPECT_EQ(scene.tolerance.force, tolerance.force);
  EXPECT_EQ(scene.tolerance.moment, tolerance.moment);
  EXPECT_EQ(scene.tolerance.margin, tolerance.margin);
  const ContactSettings contact;
  EXPECT_EQ(scene_of("box_grasp", {"contact.level=auto"}).contact.force_error, contact.force_error);
  EXPECT_EQ(scene_of("stick").contact.level, contact.level);
  EXPECT_EQ(scene_of("stick").contact.distance_error_m, contact.distance_error_m);
  EXPECT_EQ(scene.control->cone, ControlSettings{}.cone);
  EXPECT_EQ(scene.control->position.d, PidGains{}.d);
  EXPECT_FALSE(scene.only_needed);

  const Range exponents = range_of(*find_key(scene_keys(), "object.shape.superquadric.exponents"));
  EXPECT_EQ(exponents.least, kLeastExponent);
  EXPECT_EQ(exponents.most, kLargestExponent);
}

TEST(Keys, AreSuggestedFromTheirOwnMapFirst) {
  EXPECT_EQ(nearest_key(scene_keys(), "contact.frction"), "contact.friction");
  EXPECT_EQ(nearest_key(scene_keys(), "control.grasp.frction"), "control.grasp.friction");
  EXPECT_EQ(nearest_key(scene_keys(), "frction"), "contact.friction");
  EXPECT_EQ(nearest_key(scene_keys(), "contct.friction"), "contact.friction");
  EXPECT_EQ(nearest_key(scene_keys(), "task.push.position"), "task.goal.position");
  EXPECT_EQ(nearest_key(scene_keys(), "temperature_of_the_room"), "");
  // Neither the map that it is in, nor a key elsewhere with as short a name.
  EXPECT_EQ(nearest_key(scene_keys(), "control.muscles.foo"), "");
  EXPECT_EQ(nearest_key(scene_keys(), "control.muscles.stifness"), "control.muscles.stiffness");
  EXPECT_EQ(nearest_key(scene_keys(), "control.muscls.stiffness"), "control.muscles.stiffness");
}

// A word that people use for a key of the same map, before a key of another map that happens to have that name.
TEST(Keys, AreSuggestedForOtherWords) {
  EXPECT_EQ(nearest_key(scene_keys(), "object.shape.cylinder.diameter"), "object.shape.cylinder.radius");
  EXPECT_EQ(nearest_key(scene_keys(), "object.shape.mug.diameter"), "object.shape.mug.radius");
  EXPECT_EQ(nearest_key(scene_keys(), "environment.bodies.shape.hole.radius"),
            "environment.bodies.shape.hole.diameter");
  EXPECT_EQ(nearest_key(scene_keys(), "object.shape.capsule"), "object.shape.superquadric");
  EXPECT_EQ(nearest_key(scene_keys(), "object.weight"), "object.mass");
  EXPECT_NE(how_to_write("diameter", "radius"), "");
  EXPECT_EQ(how_to_write("diameter", "diameter"), "");
}

TEST(Keys, KnowTheirRanges) {
  const Range step = range_of(*find_key(scene_keys(), "time.step"));
  EXPECT_EQ(step.least, 1e-5);
  EXPECT_EQ(step.most, 1.0);
  EXPECT_FALSE(step.open);
  const Key& gain = *find_key(scene_keys(), "control.gain");
  EXPECT_TRUE(range_of(gain).open);
  EXPECT_EQ(range_of(gain).least, 0.0);
  EXPECT_EQ(words_of(gain), std::vector<std::string_view>{"auto"});
  EXPECT_EQ(range_fault(gain, 1e150, "1e150 N*m/rad"), "1e150 N*m/rad must be at most 1e7 N*m/rad");
  const Key& torques = *find_key(scene_keys(), "hand.torques");
  EXPECT_EQ(range_fault(torques, -1e300, "-1e300 N*m"), "-1e300 N*m must be at least -1e4 N*m");
  Key wrong = gain;
  for (const char* range : {"1 kg .. 2 kg", "0 and more", "> one"}) {
    wrong.range = range;
    EXPECT_THROW((void)range_of(wrong), std::logic_error) << range;
  }
}

}  // namespace
}  // namespace thenar::keys_test
