// SPDX-License-Identifier: Apache-2.0
#include "engine/scenes/yaml_tree.h"

#include <gtest/gtest.h>

#include <string>

#include "engine/formats/text.h"
#include "engine/scenes/config.h"
#include "engine/scenes/keys.h"
#include "tests/scenes/config_faults.h"

namespace thenar::yaml_tree_test {
namespace {

using namespace config_faults;

TEST(Config, RefusesWhatIsNoPlainYaml) {
  const Table table{length("a")};
  const Reader read = [](const ConfigMap& root) { (void)root.has("a"); };
  EXPECT_EQ(faults(table, "", read), (Lines{"1:1: the file is empty"}));
  EXPECT_EQ(faults(table, "# nothing\n", read), (Lines{"1:1: the file is empty"}));
  EXPECT_EQ(faults(table, "- 1\n", read), (Lines{"1:1: must be a map of keys and values, not a list"}));
  EXPECT_EQ(faults(table, "a: 1\n---\na: 2\n", read),
            (Lines{"3:1: a second document is not read: leave out the line '---'"}));
  EXPECT_EQ(faults(table, "a: &x 1\nb: *x\n", read),
            (Lines{"2:1: b: unknown key", "2:4: aliases are not read here: write the value out"}));
  EXPECT_EQ(faults(table, "a: !!float 1\n", read),
            (Lines{"1:4: tags are not read here: leave out tag:yaml.org,2002:float"}));
  EXPECT_EQ(faults(table, "? [1]\n: 2\na: 1\n", read), (Lines{"1:3: a key must be a word", "1:3: unknown key"}));
  // The parser's own words and columns differ between its versions.
  const auto syntax = [&](const std::string& broken) {
    const Lines found = faults(table, "a: 1\nb: " + broken, read);
    return found.size() == 1 && (found[0].starts_with("2:") || found[0].starts_with("3:"));
  };
  for (const char* broken : {"[1, 2\n", "'b", "b: c", "{b", "\n\t- b", "\"", "@", "%", "\"\\q\""}) {
    EXPECT_TRUE(syntax(broken)) << broken;
  }
}

// A name goes into JSON, which is UTF-8, and onto terminals, which obey control characters. So any text of a file is
// refused where it stands, and no message repeats such a byte.
TEST(Config, RefusesTextsThatAreNoLineOfUtf8) {
  const Reader read = [](const ConfigMap& root) {
    (void)root.text("name");
    if (root.has("list")) (void)root.map("map").texts("list");
    if (root.has("step")) (void)root.quantity("step");
  };
  const Table table{key("name", kText), key("list", kText), key("map", kMap), key("map.list", kTexts),
                    key("step", kQuantity, "> 0", kTime)};
  for (const char* good :
       {"name: café\n", "name: \"\\u00e9 \xE2\x82\xAC \xF0\x9F\x96\x90\"\n", "name: a # caf\xE9\n"}) {
    EXPECT_EQ(faults(table, good, read), Lines{}) << good;
  }
  EXPECT_EQ(faults(table, "# one\nname: caf\xE9\n", read),
            (Lines{"2:7: name: 'caf\\xE9' must be one line of text in UTF-8, without byte 0xE9"}));
  EXPECT_EQ(faults(table, "name: \"a\\e[2J\"\n", read),
            (Lines{"1:7: name: 'a\\x1B[2J' must be one line of text in UTF-8, without the control character 0x1B"}));
  EXPECT_EQ(faults(table, "name: a\n", read, {"name=caf\xE9"}),
            (Lines{"--set name: 'caf\\xE9' must be one line of text in UTF-8, without byte 0xE9"}));
  // Cut characters, an overlong 'A', half of a pair of UTF-16, beyond Unicode, a control character in two bytes, and
  // lines.
  for (const char* bad : {"\xC3", "\xE2\x82", "\xF0\x9F\x96", "\xC1\x81", "\xED\xA0\x80", "\xF4\x90\x80\x80",
                          "\xC2\x9B", "\"\\0\"", "\"\\n\"", "\"\\t\""}) {
    const Lines found = faults(table, "name: " + std::string(bad) + "\n", read);
    ASSERT_EQ(found.size(), 1U) << bad;
    EXPECT_TRUE(found[0].starts_with("1:7: name: '")) << found[0];
  }
  // In a list, as a key, in a value that is no text, and in what the parser itself says.
  for (const char* broken :
       {"name: a\nmap: {list: [a, b\xE9]}\nlist: 1\n", "name: a\nn\xE9: 1\n", "name: a\nstep: 1 \xB5s\n",
        "name: a\nb: *\xE9\n", "name: a\nb: !\xE9 1\n", "name: a\nb: &\xE9 1\nc: *\x1B\n"}) {
    const Lines found = faults(table, broken, read);
    EXPECT_FALSE(found.empty()) << broken;
    for (const std::string& line : found) EXPECT_EQ(first_unprintable(line), line.npos) << printable(line);
  }
}

TEST(Config, EveryTruncatedOrDeepFileIsRefusedOrRead) {
  const std::string text = kReferenceScene;
  for (std::size_t length = 0; length < text.size(); ++length) {
    EXPECT_NO_FATAL_FAILURE((void)faults(scene_keys_of("time"), text.substr(0, length),
                                         [](const ConfigMap& root) { (void)root.map("time"); }));
  }
  const Reader nothing = [](const ConfigMap&) {};
  EXPECT_FALSE(faults({}, std::string(100000, '['), nothing).empty());
  EXPECT_FALSE(faults({}, std::string(100000, '{'), nothing).empty());
}

}  // namespace
}  // namespace thenar::yaml_tree_test
