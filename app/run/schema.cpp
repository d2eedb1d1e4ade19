// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "app/run/keys.h"
#include "engine/scenes/key_table.h"
#include "engine/scenes/units.h"

namespace thenar::app {

namespace {

using Json = nlohmann::ordered_json;

/// The text as a regular expression that matches it alone.
std::string escaped(std::string_view text) {
  std::string pattern;
  for (const char c : text) {
    if (std::string_view("\\^$.|?*+()[]{}").find(c) != std::string_view::npos) pattern += '\\';
    pattern += c;
  }
  return pattern;
}

/// "auto|m|cm", each of which matches itself.
std::string any_of(const std::vector<std::string_view>& texts) {
  std::string pattern;
  for (const std::string_view text : texts) pattern += (pattern.empty() ? "" : "|") + escaped(text);
  return pattern;
}

Json number(const Key& key) {
  const Range range = range_of(key);
  Json schema{{"type", "number"}};
  if (std::isfinite(range.least)) schema[range.open ? "exclusiveMinimum" : "minimum"] = range.least;
  if (std::isfinite(range.most)) schema["maximum"] = range.most;
  return schema;
}

/// A word of digits is a number in YAML.
Json choice(const Key& key) {
  Json words = Json::array();
  for (const std::string_view word : words_of(key)) {
    words.push_back(Json::accept(word) ? Json::parse(word) : Json(word));
  }
  return {{"enum", words}};
}

/// A number with one of the units, or one of the key's words. Of the range a pattern knows the sign alone.
Json quantity(const Key& key) {
  if (key.dimension == Dimension::kNone) {
    return words_of(key).empty() ? number(key) : Json{{"anyOf", {choice(key), number(key)}}};
  }
  const std::string sign = range_of(key).least < 0.0 ? "[+-]?" : "\\+?";
  const std::string digits = R"((\d+\.?\d*|\.\d+)([eE][+-]?\d+)?)";
  std::string pattern = fmt::format("{}{} *({})", sign, digits, any_of(unit_symbols(key.dimension)));
  const std::vector<std::string_view> words = words_of(key);
  if (!words.empty()) pattern = fmt::format("({}|{})", any_of(words), pattern);
  return {{"type", "string"}, {"pattern", "^" + pattern + "$"}};
}

Json list_of(const Json& item, int count) {
  return {{"type", "array"}, {"items", item}, {"minItems", count}, {"maxItems", count}};
}

Json schema_of(const Key& key);

/// The map at a path; "" is the whole scene.
Json map_at(std::string_view path, bool of_one_key) {
  Json properties = Json::object(), required = Json::array();
  for (const Key* key : keys_below(scene_keys(), path)) {
    properties[std::string(name_of(*key))] = schema_of(*key);
    if (is_required(scene_keys(), *key)) required.push_back(name_of(*key));
  }
  Json schema{{"type", "object"}, {"additionalProperties", false}, {"properties", properties}};
  if (of_one_key) schema.update({{"minProperties", 1}, {"maxProperties", 1}});
  if (!required.empty()) schema["required"] = required;
  return schema;
}

Json value_of(const Key& key) {
  Json text{{"type", "string"}, {"minLength", 1}};
  switch (key.kind) {
    case KeyKind::kMap:
      if (!words_of(key).empty()) return {{"anyOf", {choice(key), map_at(key.path, false)}}};
      return map_at(key.path, false);
    case KeyKind::kOneOf:
      return map_at(key.path, true);
    case KeyKind::kMaps:
      return {{"type", "array"}, {"items", map_at(key.path, false)}};
    case KeyKind::kQuantity:
      return quantity(key);
    case KeyKind::kQuantities:
      if (key.items == kPerJoint) return {{"type", "array"}, {"items", quantity(key)}, {"minItems", 1}};
      return list_of(quantity(key), key.items);
    case KeyKind::kCount: {
      const Range range = range_of(key);
      return {{"type", "integer"}, {"minimum", std::llround(range.least)}, {"maximum", std::llround(range.most)}};
    }
    case KeyKind::kRotation:
      return list_of(list_of({{"type", "number"}}, 3), 3);
    case KeyKind::kText:
      return text;
    case KeyKind::kTexts:
      return {{"type", "array"}, {"items", text}, {"minItems", 1}};
    case KeyKind::kPath:
      return text;
    case KeyKind::kFlag:
      return {{"type", "boolean"}};
    case KeyKind::kChoice:
      return choice(key);
  }
  return {};
}

Json schema_of(const Key& key) {
  Json schema{{"description", key.sentence}};
  if (may_be_map(scene_keys(), key)) {
    schema["anyOf"] = {value_of(key), map_at(key.path, false)};
  } else {
    schema.update(value_of(key));
  }
  if (has_default(key) && key.kind != KeyKind::kQuantities) {
    schema["default"] = Json::accept(key.without) ? Json::parse(key.without) : Json(key.without);
  }
  return schema;
}

}  // namespace

std::string keys_as_schema() {
  Json schema{{"$schema", "https://json-schema.org/draft/2020-12/schema"},
              {"title", "A scene of Thenar"},
              {"description", "Written by thenar schema."}};
  schema.update(map_at("", false));
  return schema.dump(2) + "\n";
}

}  // namespace thenar::app
