// SPDX-License-Identifier: Apache-2.0
#include "engine/scenes/config.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "engine/formats/files.h"
#include "engine/scenes/key_table.h"
#include "tests/scenes/config_faults.h"

namespace thenar::config_test {
namespace {

using namespace config_faults;

TEST(Config, ReadsEveryFormOfValueInSI) {
  Config config(scene_file(kReferenceScene), scene_keys());
  const ConfigMap root = config.root();
  EXPECT_EQ(root.text("name"), "box grasp");

  const ConfigMap time = root.map("time");
  EXPECT_EQ(time.quantity("duration"), 2.5);
  EXPECT_EQ(time.quantity("step"), 1e-3);
  EXPECT_EQ(time.quantity("control_period"), 1e-3);
  EXPECT_EQ(root.quantities("gravity"), Eigen::Vector3d(7.018620, 5.581331, 3.977916));

  const ConfigMap hand = root.map("hand");
  EXPECT_EQ(hand.path("model"), scene_file(kReferenceScene).parent_path() / "hand.yaml");
  const Eigen::VectorXd posture = hand.quantities("posture", 12);
  EXPECT_EQ(posture.head<3>(), Eigen::Vector3d(0.08634660, 0.25390447, -std::numbers::pi / 2));
  EXPECT_EQ(hand.quantity("joint_viscosity"), 0.05);

  const ConfigMap tips = root.map("fingertips");
  EXPECT_EQ(tips.count("points"), 2400);
  EXPECT_EQ(tips.quantity("reduced_modulus"), 0.24e6);
  EXPECT_EQ(tips.quantity("poisson"), 0.5);
  EXPECT_EQ(tips.quantity("relaxation"), 2e-3);
  EXPECT_EQ(tips.choice("kernel"), "boussinesq");

  const ConfigMap object = root.map("object");
  EXPECT_EQ(object.map("shape").one_of(), "box");
  EXPECT_EQ(object.map("shape").quantities("box"), Eigen::Vector3d::Constant(0.05));
  EXPECT_EQ(object.count("points"), 36000);
  EXPECT_EQ(object.quantity("mass"), 0.1);
  // Seven digits and a division round twice: one unit in the last place, at most 2^-52 of the value.
  const Eigen::Vector3d centre_m(0.11943952, 0.04626999, 0.03652549);
  EXPECT_TRUE(object.quantities("position").isApprox(centre_m, 0x1p-52));
  EXPECT_EQ(object.rotation("rotation"), (Eigen::Matrix3d() << 0, 0, 1, 1, 0, 0, 0, 1, 0).finished());
  EXPECT_EQ(object.map("damping").quantity("translation"), 10.0);
  EXPECT_EQ(object.map("damping").quantity("rotation"), 0.005);

  const ConfigMap contact = root.map("contact");
  EXPECT_EQ(contact.quantity("friction"), 0.8);
  EXPECT_EQ(contact.quantity("band"), 0.3e-3);
  EXPECT_EQ(contact.count("max_per_finger"), 20);
  EXPECT_EQ(contact.quantity("tolerance"), 1e-6);
  EXPECT_EQ(contact.count("max_sweeps"), 200);

  const ConfigMap control = root.map("control");
  EXPECT_EQ(control.choice("law"), "feedforward");
  EXPECT_EQ(control.word("gain"), "auto");
  EXPECT_EQ(control.map("pulp").quantity("normal"), 2000.0);
  EXPECT_EQ(control.map("pulp").quantity("tangential"), 1330.0);
  const ConfigMap position = control.map("position");
  EXPECT_EQ(position.quantity("p"), 300.0);
  EXPECT_EQ(position.quantity("i"), 900.0);
  EXPECT_EQ(position.quantity("d"), 0.0);
  const ConfigMap rotation = control.map("rotation");
  EXPECT_EQ(rotation.quantity("p"), 0.48);
  EXPECT_EQ(rotation.quantity("i"), 1.5);
  EXPECT_EQ(rotation.quantity("d"), 0.0);
  EXPECT_EQ(control.word("muscles"), "true");

  const ConfigMap translate = root.map("task").map("translate");
  EXPECT_EQ(translate.quantities("by"), Eigen::Vector3d(0, 0.02, 0));
  EXPECT_EQ(translate.quantity("from"), 0.4);
  EXPECT_EQ(translate.quantity("over"), 0.8);
  EXPECT_NO_THROW(config.finish());
  EXPECT_TRUE(config.defaults_used().empty());
}

TEST(Config, ReportsAllFaultsInTheOrderOfTheFile) {
  const Table table{key("contact", kMap),
                    key("contact.friction", kQuantity, "0 .. 2"),
                    length("contact.band", "> 0"),
                    key("contact.max_sweeps", kCount, "1 .. 1000"),
                    key("time", kMap),
                    key("time.step", kQuantity, "> 0", kTime),
                    key("object", kMap),
                    key("time.duration", kQuantity, "> 0", kTime),
                    key("object.mass", kQuantity, "> 0", kMass)};
  const Reader read = [](const ConfigMap& root) {
    const ConfigMap contact = root.map("contact");
    (void)contact.quantity("friction");
    (void)contact.quantity("band");
    (void)contact.count("max_sweeps");
    const ConfigMap time = root.map("time");
    (void)time.quantity("step");
    (void)time.quantity("duration");
    (void)root.map("object").quantity("mass");
  };
  const Lines found = faults(table, R"(# A scene with faults
time:
  step: 1
  stpe: 1 ms
contact:
  friction: 0.8
  band: -0.3 mm
  max_sweeps: 2000
  max_sweeps: 200
)",
                             read);
  EXPECT_EQ(found, (Lines{
                       "2:1: object: this key is missing",
                       "2:1: time.duration: this key is missing",
                       "3:9: time.step: 1 has no unit: use s, ms or us",
                       "4:3: time.stpe: unknown key, did you mean 'time.step'?",
                       "7:9: contact.band: -0.3 mm must be greater than zero",
                       "8:15: contact.max_sweeps: 2000 must be at most 1000",
                       "9:3: contact.max_sweeps: this key is already in line 8",
                   }));
}

TEST(Config, SuggestsNearKeysOnly) {
  Table table;
  for (const char* name : {"p", "law", "friction", "relaxation_time_of_the_pulp"}) {
    table.push_back(length(name, "", "(Nothing.)"));
  }
  const Reader nothing = [](const ConfigMap&) {};
  EXPECT_EQ(faults(table, "d: 1", nothing), (Lines{"1:1: d: unknown key"}));
  EXPECT_EQ(faults(table, "lwa: 1", nothing), (Lines{"1:1: lwa: unknown key, did you mean 'law'?"}));
  EXPECT_EQ(faults(table, "fiction: 1", nothing), (Lines{"1:1: fiction: unknown key, did you mean 'friction'?"}));
  EXPECT_EQ(faults(table, "relaxationtimeofthepulp: 1", nothing),
            (Lines{"1:1: relaxationtimeofthepulp: unknown key, did you mean 'relaxation_time_of_the_pulp'?"}));
  EXPECT_EQ(faults(table, "gravity: 1", nothing), (Lines{"1:1: gravity: unknown key"}));
}

TEST(Config, SuggestsKeysOfOtherMaps) {
  const Table table{key("contact", kMap), length("contact.friction")};
  const Reader read = [](const ConfigMap& root) { (void)root.map("contact").quantity("friction"); };
  // It is not missing besides.
  EXPECT_EQ(faults(table, "contact: {}\nfriction: 1 m\n", read),
            (Lines{"2:1: friction: unknown key, did you mean 'contact.friction'?"}));
  EXPECT_EQ(faults(table, "contact: {friction: 1 m}\ncontact.friction: 1 m\n", read),
            (Lines{"2:1: contact.friction: in a file each name stands below the one before it, without dots"}));
  EXPECT_EQ(faults(table, "contact: {}\n", read, {"frcition=1 m"}),
            (Lines{"--set frcition: unknown key, did you mean 'contact.friction'?"}));
}

// Nothing in a file is ignored, and a key that is good elsewhere is not an unknown one.
TEST(Config, RefusesKeysThatThisSceneHasNoUseFor) {
  const Reader nothing = [](const ConfigMap&) {};
  EXPECT_EQ(faults({length("leaves")}, "leaves: 1 m", nothing),
            (Lines{"1:1: leaves: has no effect here: leave it out"}));
}

TEST(Config, RefusesNumbersOutOfRange) {
  const Table table{length("a", "> 0"),        length("b", ">= 0"),
                    length("c", ">= 0"),       key("d", kQuantities, "> 0", kLength, 3),
                    length("e", "> 0 | auto"), length("f", "1 mm .. 1 m"),
                    length("g", ">= 1 mm"),    length("h", "1 mm .. 1 m"),
                    length("i", "> 1 mm")};
  const Reader read = [](const ConfigMap& root) {
    for (const char* name : {"a", "b", "c", "e", "f", "g", "h", "i"}) (void)root.quantity(name);
    (void)root.quantities("d");
  };
  EXPECT_EQ(
      faults(table, "a: 0 m\nb: -1 m\nc: 0 m\nd: [1 m, 0 m, 1 m]\ne: -1 m\nf: 1.1 m\ng: 0 m\nh: 0.9 mm\ni: 1 mm\n",
             read),
      (Lines{
          "1:4: a: 0 m must be greater than zero",
          "2:4: b: -1 m must not be negative",
          "4:10: d[1]: 0 m must be greater than zero",
          "5:4: e: -1 m must be greater than zero",
          "6:4: f: 1.1 m must be at most 1 m",
          "7:4: g: 0 m must be at least 1 mm",
          "8:4: h: 0.9 mm must be at least 1 mm",
          "9:4: i: 1 mm must be greater than 1 mm",
      }));
  EXPECT_EQ(
      faults(table, "{a: 1 m, b: 1 m, c: 1 m, d: [1 m, 1 m, 1 m], e: 1 m, f: 1000 mm, g: 0.001 m, h: 1 mm, i: 1 m}",
             read),
      Lines{})
      << "the ends are in the range";
}

TEST(Config, RefusesWrongPlainValues) {
  const Table table{key("a", kQuantity, "0 .. 0.5"),
                    key("b", kQuantity, "0 .. 0.5"),
                    key("c", kCount, "1 .. 9"),
                    key("d", kCount, "1 .. 9"),
                    key("e", kCount, "1 .. 9"),
                    key("f", kFlag),
                    key("g", kFlag),
                    key("h", kChoice, "pyramid | exact"),
                    key("i", kText),
                    key("j", kText),
                    key("k", kTexts),
                    key("l", kCount, "1 .. 9"),
                    key("m", kCount, "1 .. 9"),
                    key("n", kCount),
                    key("o", kCount)};
  const Reader read = [](const ConfigMap& root) {
    for (const char* name : {"a", "b"}) (void)root.quantity(name);
    for (const char* name : {"c", "d", "e", "l", "m", "n", "o"}) (void)root.count(name);
    for (const char* name : {"f", "g"}) (void)root.flag(name);
    for (const char* name : {"i", "j"}) (void)root.text(name);
    (void)root.choice("h");
    (void)root.texts("k");
  };
  EXPECT_EQ(faults(table, R"(a: 0.6
b: -1
c: 0
d: 1.5
e: many
f: yes
g: [true]
h: piramid
i:
j: ""
k: []
l: 99999999999999999999
m: -99999999999999999999
n: 1e5
o: 2,000
)",
                   read),
            (Lines{
                "1:4: a: 0.6 must be at most 0.5",
                "2:4: b: -1 must be at least 0",
                "3:4: c: 0 must be at least 1",
                "4:4: d: '1.5' is not a whole number",
                "5:4: e: 'many' is not a whole number",
                "6:4: f: 'yes' is not true or false, did you mean 'true'?",
                "7:4: g: must be true or false, not a list",
                "8:4: h: 'piramid' is not one of pyramid, exact, did you mean 'pyramid'?",
                "9:1: i: must be a text, not nothing",
                "10:4: j: must not be empty",
                "11:4: k: must not be empty",
                "12:4: l: 99999999999999999999 must be at most 9",
                "13:4: m: -99999999999999999999 must be at least 1",
                "14:4: n: '1e5' is not a whole number: write 100000",
                "15:4: o: '2,000' is not a whole number: write 2000",
            }));
}

TEST(Config, RefusesWrongLists) {
  const Table table{key("a", kQuantities, "", kLength, 3),
                    key("b", kQuantities, "", kLength, 3),
                    key("c", kQuantities, "", kAngle, 2),
                    key("d", kRotation),
                    key("e", kRotation),
                    key("f", kQuantities, "", kNone, 3),
                    key("g", kQuantities, "", kNone, 2),
                    key("h", kMaps),
                    key("i", kQuantities, "", kLength, 3),
                    key("j", kQuantities, "", kLength, 3)};
  const Reader read = [](const ConfigMap& root) {
    for (const char* name : {"a", "b", "c", "f", "g", "i", "j"}) (void)root.quantities(name);
    for (const char* name : {"d", "e"}) (void)root.rotation(name);
    (void)root.list_of_maps("h");
  };
  EXPECT_EQ(faults(table, R"(a: 1 m
b: [1 m, 2 m]
c: [1 rad, 2 m]
d: [[1, 0, 0], [0, 1, 0]]
e: [[1, 0, 0], [0, 1], [0, x, 1]]
f: [1, 2, 3 m]
g:
  - 1
  - {}
h: [{}, 1]
i: [1,5 m, 2,5 m, 3,5 m]
j: [1 m 2 m 3 m]
)",
                   read),
            (Lines{
                "1:4: a: must be a list of 3 values, not a single value",
                "2:4: b: must be a list of 3 values, not 2",
                "3:12: c[1]: 2 m is not an angle: use rad or deg",
                "4:4: d: must be a list of 3 rows, not 2",
                "5:16: e[1]: must be a list of 3 values, not 2",
                "5:28: e[2][1]: 'x' is not a plain number",
                "6:11: f[2]: 3 m must be a plain number, without 'm'",
                "9:5: g[1]: must be a plain number, not a map",
                "10:9: h[1]: must be a map of keys and values, not a single value",
                "11:4: i: must be a list of 3 values, not 6: the mark in a number is '.', not ','",
                "12:4: j: must be a list of 3 values, not 1: write ',' between them",
            }));
}

TEST(Config, ReportsAMissingMapOnce) {
  Table table;
  const auto add = [&](const char* map, const char* mass, const char* shape, const char* box) {
    table.insert(table.end(), {key(map, kMap), key(mass, kQuantity, "> 0", kMass), key(shape, kOneOf), length(box)});
  };
  add("missing", "missing.mass", "missing.shape", "missing.shape.box");
  add("value", "value.mass", "value.shape", "value.shape.box");
  add("nothing", "nothing.mass", "nothing.shape", "nothing.shape.box");
  const Reader read = [](const ConfigMap& root) {
    for (const char* name : {"missing", "value", "nothing"}) {
      const ConfigMap map = root.map(name);
      EXPECT_GT(map.quantity("mass"), 0.0);
      EXPECT_EQ(map.map("shape").one_of(), "");
      EXPECT_FALSE(map.has("mass"));
      map.refuse("mass", "is wrong");
    }
  };
  EXPECT_EQ(faults(table, "value: 1\nnothing:\n", read),
            (Lines{
                "1:1: missing: this key is missing",
                "1:8: value: must be a map of keys and values, not a single value",
                "2:1: nothing: must be a map of keys and values, not nothing",
            }));
}

TEST(Config, FindsFaultsInsideListsOfMaps) {
  const Reader read = [](const ConfigMap& root) {
    for (const ConfigMap& muscle : root.list_of_maps("muscles")) {
      (void)muscle.text("name");
      (void)muscle.quantity("length");
    }
  };
  const Table table{key("muscles", kMaps), key("muscles.name", kText), length("muscles.length")};
  EXPECT_EQ(faults(table, "muscles:\n- {name: OP, length: 1 m}\n- {nmae: APL, length: 1 m}\n", read),
            (Lines{
                "3:4: muscles[1].nmae: unknown key, did you mean 'muscles[1].name'?",
            }));
}

TEST(Config, WantsOneOfSeveralKeys) {
  const Reader read = [](const ConfigMap& root) {
    const ConfigMap shape = root.map("shape");
    const std::string kind = shape.one_of();
    if (kind == "sphere") (void)shape.quantity("sphere");
  };
  const Table table{key("shape", kOneOf), length("shape.box"), length("shape.sphere")};
  EXPECT_EQ(faults(table, "shape: {sphere: 1 m}", read), (Lines{}));
  EXPECT_EQ(faults(table, "shape: {}", read), (Lines{"1:1: shape: needs one of box, sphere"}));
  EXPECT_EQ(faults(table, "shape: {box: 1 m, sphere: 1 m}", read),
            (Lines{"1:19: shape.sphere: only one of box, sphere may be given"}));
}

TEST(Config, ReportsWhatTheCallerRefuses) {
  const Reader read = [](const ConfigMap& root) {
    (void)root.quantity("a");
    (void)root.quantity("b");
    root.refuse("a", "must not exceed b");
    root.refuse("b", "is reported already, as a wrong unit");
    root.refuse("c", "is needed with a");
  };
  EXPECT_EQ(faults({length("a"), length("b"), length("c")}, "a: 1 m\nb: 1 s\n", read),
            (Lines{
                "1:1: c: is needed with a",
                "1:4: a: must not exceed b",
                "2:4: b: 1 s is not a length: use m, cm, mm or um",
            }));
}

// A default is read as if it stood in the file.
TEST(Config, ListsTheDefaultsThatWereUsed) {
  const Table table{length("present", "", "5 mm"),
                    length("band", "", "0.3 mm"),
                    key("contact", kMap),
                    key("contact.by", kQuantities, "", kLength, 3, "[1 m, 2 m, 3 mm]"),
                    key("contact.sweeps", kCount, "1 .. 100", kNone, 1, "60"),
                    key("contact.cone", kChoice, "pyramid | exact", kNone, 1, "exact"),
                    length("contact.centre", "", "(The middle.)")};
  Config config(scene_file("{present: 1 mm, contact: {}}"), table);
  const ConfigMap root = config.root();
  EXPECT_EQ(root.quantity("present"), 1e-3);
  EXPECT_EQ(root.quantity("band"), 3e-4);
  const ConfigMap contact = root.map("contact");
  EXPECT_EQ(contact.quantities("by"), Eigen::Vector3d(1.0, 2.0, 3e-3));
  EXPECT_EQ(contact.count("sweeps"), 60);
  EXPECT_EQ(contact.choice("cone"), "exact");
  contact.use_default("centre", "4 m");
  EXPECT_NO_THROW(config.finish());
  EXPECT_EQ(config.defaults_used(), (Lines{
                                        "band: 0.3 mm",
                                        "contact.by: [1 m, 2 m, 3 mm]",
                                        "contact.sweeps: 60",
                                        "contact.cone: exact",
                                        "contact.centre: 4 m",
                                    }));
}

TEST(Config, ADefaultDoesNotHideAFault) {
  const Reader read = [](const ConfigMap& root) { (void)root.quantity("band"); };
  const Table table{length("band", ">= 0", "1 m")};
  EXPECT_EQ(faults(table, "band: -1 m\n", read), (Lines{"1:7: band: -1 m must not be negative"}));
  // A sentence in brackets is no value.
  EXPECT_EQ(faults({length("band", ">= 0", "(None.)")}, "{}", read), (Lines{"1:1: band: this key is missing"}));
}

// What the table does not have cannot be read: a key that is forgotten there fails at the first scene.
TEST(Config, ReadsNothingThatTheTableDoesNotHave) {
  const Table table{length("band"), key("time", kMap)};
  Config config(scene_file("{band: 1 m, step: 1 m, time: {}}"), table);
  const ConfigMap root = config.root();
  EXPECT_THROW((void)root.quantity("step"), std::logic_error);
  EXPECT_THROW((void)root.has("step"), std::logic_error);
  EXPECT_THROW((void)root.map("time").quantity("band"), std::logic_error);
  EXPECT_THROW((void)root.count("band"), std::logic_error) << "of another kind";
  EXPECT_EQ(root.quantity("band"), 1.0);
}

TEST(Config, TheCommandLineSetsValues) {
  const std::string text = "time: {step: 1 ms}\nhand: {model: hand.yaml}\nobject: {shape: {sphere: 1 m}}\n";
  const Lines overrides{
      "time.step=0.5 ms",      "object.mass=100 g",          "gravity=[0 m/s^2, 0 m/s^2, -9.81 m/s^2]",
      "hand.model=other.yaml", "object.shape={sphere: 2 m}", "time.step=0.25 ms"};
  Config config(scene_file(text), scene_keys(), overrides);
  const ConfigMap root = config.root();
  EXPECT_EQ(root.map("time").quantity("step"), 0.25e-3) << "the last one counts";
  EXPECT_EQ(root.map("object").quantity("mass"), 0.1);
  EXPECT_EQ(root.quantities("gravity"), Eigen::Vector3d(0, 0, -9.81));
  EXPECT_EQ(root.map("hand").path("model"), "other.yaml") << "of the working directory";
  EXPECT_EQ(root.map("object").map("shape").one_of(), "sphere");
  EXPECT_EQ(root.map("object").map("shape").quantity("sphere"), 2.0);
  EXPECT_NO_THROW(config.finish());
}

TEST(Config, ReportsFaultsOfTheCommandLineThere) {
  const Reader read = [](const ConfigMap& root) {
    (void)root.map("time").quantity("step");
    (void)root.map("time").quantity("duration");
  };
  EXPECT_EQ(faults(scene_keys_of("time"), "time: {step: 1 ms, duration: 1}", read,
                   {"time.step=-1 ms", "time.stap=1", "tme.step=1", "time.step.x=1", "step", "a..b=1", "time.step"}),
            (Lines{
                "1:30: time.duration: 1 has no unit: use s, ms or us",
                "--set time.step: -1 ms must be at least 10 us",
                "--set time.stap: unknown key, did you mean 'time.step'?",
                "--set tme.step: tme: unknown key, did you mean 'time'?",
                "--set time.step.x: time.step is not a map of keys and values",
                "--set step: write it as key=value, such as time.step=0.5 ms",
                "--set a..b: write it as key=value, such as time.step=0.5 ms",
                "--set time.step: write it as key=value, such as time.step=0.5 ms",
            }));
  const Lines broken = faults(scene_keys_of("time"), "time: {duration: 1 s}", read, {"time.step=[1"});
  ASSERT_EQ(broken.size(), 1u);
  EXPECT_TRUE(broken[0].starts_with("--set time.step: ")) << broken[0];
}

TEST(Config, NamesAMissingFile) {
  try {
    const Config config("/nowhere/scene.yaml", scene_keys());
    FAIL();
  } catch (const FileError& error) {
    EXPECT_STREQ(error.what(), "/nowhere/scene.yaml: no such file");
  }
  EXPECT_THROW(Config(testing::TempDir(), scene_keys()), FileError);
}

}  // namespace
}  // namespace thenar::config_test
