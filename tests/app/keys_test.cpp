// SPDX-License-Identifier: Apache-2.0
// What `thenar keys`, `thenar fields` and `thenar schema` print, and that the documents made of it are up to date.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "engine/scenes/yaml_tree.h"
#include "tests/support/program.h"

namespace thenar::keys_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

const fs::path kRoot = fs::path(THENAR_CONFIGS).parent_path();

TEST(KeysProgram, ListsTheKeysBelowAPrefix) {
  const ProgramResult contact = thenar_program("keys contact");
  EXPECT_EQ(contact.code, 0);
  EXPECT_NE(contact.text.find("\ncontact.friction  "), std::string::npos) << contact.text;
  EXPECT_NE(contact.text.find("  0 .. 10  "), std::string::npos) << contact.text;
  EXPECT_EQ(contact.text.find("control."), std::string::npos) << contact.text;
  // Aligned: each column begins where its header does.
  const std::size_t range = contact.text.find("range");
  for (std::size_t line = 0; line < contact.text.size(); line = contact.text.find('\n', line) + 1) {
    EXPECT_EQ(contact.text.substr(line + range - 2, 2), "  ");
    EXPECT_EQ(contact.text[line + contact.text.find("meaning") - 1], ' ');
  }
  const std::string one = thenar_program("keys control.gain").text;
  EXPECT_EQ(std::count(one.begin(), one.end(), '\n'), 2) << one;
  EXPECT_NE(one.find("> 0 .. 1e7 N*m/rad or auto"), std::string::npos) << one;
  EXPECT_NE(thenar_program("keys").text.find("\ntask.push.over "), std::string::npos);
}

TEST(KeysProgram, SuggestsAKeyForAnUnknownOne) {
  const ProgramResult map = thenar_program("keys contct"), key = thenar_program("keys frction");
  EXPECT_EQ(map.code, 2);
  EXPECT_EQ(map.text, "keys contct: unknown key, did you mean 'contact'?\n");
  EXPECT_EQ(key.text, "keys frction: unknown key, did you mean 'contact.friction'?\n");
  EXPECT_EQ(thenar_program("keys zzzzzz").text, "keys zzzzzz: unknown key; thenar keys lists all\n");
  EXPECT_EQ(thenar_program("keys ''").code, 2);
}

/// A document is what the program prints, byte for byte.
void expect_current(const fs::path& file, const std::string& command) {
  const ProgramResult printed = thenar_program(command);
  EXPECT_EQ(printed.code, 0);
  EXPECT_TRUE(read(kRoot / file) == printed.text)
      << file.string() << " is not current. Renew it with: build/release/app/thenar " << command << " > "
      << file.string();
}

TEST(KeysProgram, ThePageOfKeysIsCurrent) { expect_current("docs/reference/scene.md", "keys --markdown"); }
TEST(FieldsProgram, ThePageOfFieldsIsCurrent) { expect_current("docs/reference/fields.md", "fields"); }
TEST(FieldsProgram, ThePageOfMeasuresIsCurrent) { expect_current("docs/reference/measures.md", "fields --measures"); }

/// The lines of Python's stub below a comment, to the end of the class, without docstrings: they are compared with the
/// module's by tests/python/test_types.py.
std::string stub_below(const std::string& comment) {
  static const std::regex kDocstring(R"rx(:\n        """[^"]*""")rx");
  static const std::string kStub = std::regex_replace(read(kRoot / "python/thenar/_core.pyi"), kDocstring, ": ...");
  const std::string mark = "    # " + comment + ", as `thenar fields --stub` prints them.\n";
  const std::size_t begin = kStub.find(mark) + mark.size();
  return kStub.substr(begin, kStub.find("\n\n", begin) + 1 - begin);
}

// Python's stub has these fields and no other. Three names mean more there: they are bound by hand.
TEST(FieldsProgram, TheStubIsCurrent) {
  const std::string printed = thenar_program("fields --stub").text;
  const std::size_t end = printed.find("\n\n");
  std::istringstream fields(printed.substr(0, end + 1));
  std::string expected;
  for (std::string first, second; std::getline(fields, first) && std::getline(fields, second);) {
    if (std::regex_search(second, std::regex(" (contacts|reflex|target)\\("))) continue;
    expected += first + '\n' + second + '\n';
  }
  EXPECT_EQ(stub_below("The fields of a tick"), expected);
  EXPECT_EQ(stub_below("The measures of a found grasp"), printed.substr(end + 2));
}

TEST(KeysProgram, TheSchemaIsCurrent) { expect_current("docs/reference/scene.schema.json", "schema"); }

/// A value of a file as an editor takes it: plain words of digits are numbers, `true` and `false` flags.
json as_json(const YamlNode& node) {
  switch (node.kind) {
    case YamlNode::Kind::kNull:
      return nullptr;
    case YamlNode::Kind::kScalar:
      return json::accept(node.text) ? json::parse(node.text) : json(node.text);
    case YamlNode::Kind::kList: {
      json list = json::array();
      for (const auto& item : node.items) list.push_back(as_json(*item));
      return list;
    }
    case YamlNode::Kind::kMap: {
      json map = json::object();
      for (const YamlNode::Entry& entry : node.entries) map[entry.key] = as_json(*entry.value);
      return map;
    }
  }
  return {};
}

bool is_of_type(const json& value, const std::string& type) {
  if (type == "object") return value.is_object();
  if (type == "array") return value.is_array();
  if (type == "string") return value.is_string();
  if (type == "boolean") return value.is_boolean();
  if (type == "integer") return value.is_number_integer();
  return type == "number" && value.is_number();
}

std::string first_fault(const json& schema, const json& value);

/// What is wrong with the parts of a list or a map.
std::string first_fault_below(const json& schema, const json& value) {
  if (value.is_array()) {
    for (const json& item : value) {
      if (const std::string fault = first_fault(schema.at("items"), item); !fault.empty()) return fault;
    }
    return "";
  }
  for (const json& name : schema.value("required", json::array())) {
    if (!value.contains(name.get<std::string>())) return name.get<std::string>() + " is missing";
  }
  for (const auto& [name, part] : value.items()) {
    if (!schema.at("properties").contains(name)) return name + " is unknown";
    const std::string fault = first_fault(schema.at("properties").at(name), part);
    if (!fault.empty()) return name + ": " + fault;
  }
  return "";
}

/// What is wrong with a value by as much of JSON Schema as ours uses; empty if nothing is. Throws at a keyword that it
/// does not know, so that none goes unchecked.
std::string first_fault(const json& schema, const json& value) {
  const std::size_t size = value.is_string() ? value.get<std::string>().size() : value.size();
  for (const auto& [word, rule] : schema.items()) {
    bool good = true;
    if (word == "type") {
      good = is_of_type(value, rule);
    } else if (word == "enum") {
      good = std::ranges::find(rule, value) != rule.end();
    } else if (word == "pattern") {
      good = value.is_string() && std::regex_search(value.get<std::string>(), std::regex(rule.get<std::string>()));
    } else if (word == "anyOf") {
      good = std::ranges::any_of(rule, [&](const json& one) { return first_fault(one, value).empty(); });
    } else if (word == "exclusiveMinimum") {
      good = value.is_number() && value.get<double>() > rule.get<double>();
    } else if (word == "minimum") {
      good = value.is_number() && value.get<double>() >= rule.get<double>();
    } else if (word == "maximum") {
      good = value.is_number() && value.get<double>() <= rule.get<double>();
    } else if (word == "minItems" || word == "minProperties" || word == "minLength") {
      good = size >= rule.get<std::size_t>();
    } else if (word == "maxItems" || word == "maxProperties") {
      good = size <= rule.get<std::size_t>();
    } else if (word == "additionalProperties") {
      EXPECT_EQ(rule, false);
    } else if (word != "$schema" && word != "title" && word != "description" && word != "default" && word != "items" &&
               word != "properties" && word != "required") {
      throw std::logic_error("a keyword of JSON Schema that this test does not know: " + word);
    }
    if (!good) return value.dump() + " breaks " + word + " " + rule.dump();
  }
  return schema.contains("items") || schema.contains("properties") ? first_fault_below(schema, value) : "";
}

std::string fault_in(const std::string& yaml) {
  static const json kSchema = json::parse(read(kRoot / "docs/reference/scene.schema.json"));
  std::vector<YamlFault> faults;
  const auto root = read_yaml(yaml, 0, faults);
  EXPECT_TRUE(root && faults.empty());
  return first_fault(kSchema, as_json(*root));
}

// An editor finds the schema by a scene's first line, and nothing wrong.
TEST(KeysProgram, AllScenesSatisfyTheSchema) {
  int scenes = 0;
  for (const auto& entry : fs::directory_iterator(THENAR_CONFIGS)) {
    if (entry.path().extension() != ".yaml" || entry.path().filename() == "hand.yaml") continue;
    const std::string text = read(entry.path());
    EXPECT_TRUE(text.starts_with("# yaml-language-server: $schema=../docs/reference/scene.schema.json\n"))
        << entry.path();
    EXPECT_EQ(fault_in(text), "") << entry.path();
    ++scenes;
  }
  EXPECT_GT(scenes, 0);
}

TEST(KeysProgram, TheSchemaFindsWhatIsWrong) {
  const std::string scene = read(config("box_grasp.yaml"));
  const auto with = [&](const std::string& good, const std::string& bad) {
    const std::size_t at = scene.find(good);
    EXPECT_NE(at, std::string::npos) << good;
    return fault_in(std::string(scene).replace(at, good.size(), bad));
  };
  EXPECT_EQ(with("friction: 0.8", "friction: 0.9"), "");
  EXPECT_EQ(with("friction: 0.8", "frcition: 0.8"), "contact: friction is missing");
  EXPECT_EQ(with("friction: 0.8", "friction: 0.8, colour: 1"), "contact: colour is unknown");
  EXPECT_EQ(with("friction: 0.8", "friction: 11"), "contact: friction: 11 breaks maximum 10.0");
  EXPECT_EQ(with("gain: auto", "gain: 30 N*m/rad"), "");
  for (const char* bad : {"gain: atuo", "gain: 30", "gain: 30 N", "gain: -30 N*m/rad"}) {
    EXPECT_TRUE(with("gain: auto", bad).starts_with("control: gain: ")) << bad;
  }
  EXPECT_TRUE(with("law: feedforward", "law: forward").starts_with("control: law: "));
  EXPECT_TRUE(with("muscles: true", "muscles: 1").starts_with("control: muscles: "));
  EXPECT_TRUE(with("max_sweeps: 200", "max_sweeps: 1.5").starts_with("contact: max_sweeps: "));
  EXPECT_TRUE(with("box: [50 mm, ", "box: [").starts_with("object: shape: box: "));
  EXPECT_TRUE(with("box: [", "sphere: 1 mm, box: [").starts_with("object: shape: "));
  EXPECT_EQ(with("max_per_finger: 22", "max_per_finger: 22, level: 3"), "");
  EXPECT_EQ(with("max_per_finger: 22", "max_per_finger: 22, level: auto"), "");
  EXPECT_TRUE(with("max_per_finger: 22", "max_per_finger: 22, level: 9").starts_with("contact: level: "));
}

}  // namespace
}  // namespace thenar::keys_test
