// SPDX-License-Identifier: Apache-2.0
#include "app/run/keys.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <vector>

#include "engine/formats/text.h"
#include "engine/scenes/config.h"
#include "engine/scenes/key_table.h"

namespace thenar::app {

namespace {

/// Key, value, range, default and meaning.
using Row = std::array<std::string, 5>;

/// `code` is put around what a user writes.
std::string plain_value_in_words(const Key& key, std::string_view code) {
  const std::string units = key.dimension == Dimension::kNone ? "number" : unit_names(key.dimension);
  std::string unit = units == "number" ? units : fmt::format("{0}{1}{0}", code, units);
  switch (key.kind) {
    case KeyKind::kMap:
      return words_of(key).empty() ? "map" : fmt::format("map or {0}{1}{0}", code, join(words_of(key), ", "));
    case KeyKind::kOneOf:
      return "map of one key";
    case KeyKind::kMaps:
      return "list of maps";
    case KeyKind::kQuantity:
      return unit;
    case KeyKind::kQuantities:
      return key.items == kPerJoint ? fmt::format("{} a joint", unit) : fmt::format("{} x {}", key.items, unit);
    case KeyKind::kCount:
      return "whole number";
    case KeyKind::kRotation:
      return "3 rows of 3 numbers";
    case KeyKind::kText:
      return "text";
    case KeyKind::kTexts:
      return "list of texts";
    case KeyKind::kPath:
      return "file";
    case KeyKind::kFlag:
      return fmt::format("{0}true, false{0}", code);
    case KeyKind::kChoice:
      return fmt::format("{0}{1}{0}", code, join(words_of(key), ", "));
  }
  return "";
}

std::string value_in_words(const Key& key, std::string_view code) {
  return plain_value_in_words(key, code) + (may_be_map(scene_keys(), key) ? " or map" : "");
}

std::string range_in_words(const Key& key) {
  if (key.kind == KeyKind::kChoice || key.kind == KeyKind::kMap) return "";
  std::string range(key.range.substr(0, key.range.find(" | ")));
  if (key.kind == KeyKind::kQuantity || key.kind == KeyKind::kQuantities) {
    const Range ends = range_of(key);
    range = fmt::format("{}{} .. {}", ends.open ? "> " : "", ends.least_text, ends.most_text);
  }
  for (const std::string_view word : words_of(key)) range += fmt::format(" or {}", word);
  return range;
}

/// How it is changed in the window.
std::string live_in_words(const LiveKey& live, std::string_view code) {
  std::string words = fmt::format(" While it runs: {0}{1}{0}", code, live.name);
  if (live.least < live.most) words += fmt::format(", {} .. {}", live.least, live.most);
  if (!live.unit.empty()) words += fmt::format(" {}", live.unit);
  return words + ".";
}

Row row_of(const Key& key, std::string_view code) {
  const auto quoted = [&](std::string_view text) {
    return text.empty() ? std::string() : fmt::format("{0}{1}{0}", code, text);
  };
  Row row{quoted(key.path), value_in_words(key, code), quoted(range_in_words(key)), "", std::string(key.sentence)};
  if (has_default(key)) {
    row[3] = quoted(key.without);
  } else if (is_required(scene_keys(), key)) {
    row[3] = "required";
  } else if (!key.without.empty()) {
    row[4] += fmt::format(" {}", key.without.substr(1, key.without.size() - 2));
  }
  if (!key.live.name.empty()) row[4] += live_in_words(key.live, code);
  return row;
}

const Row kHeader{"key", "value", "range", "default", "meaning"};

bool is_below(const Key& key, std::string_view prefix) {
  return prefix.empty() || key.path == prefix || key.path.starts_with(std::string(prefix) + ".");
}

std::string aligned(const std::vector<Row>& rows) {
  std::array<std::size_t, 4> widths{};
  for (const Row& row : rows) {
    for (std::size_t i = 0; i < widths.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::string text;
  for (const Row& row : rows) {
    for (std::size_t i = 0; i < widths.size(); ++i) text += fmt::format("{:<{}}  ", row[i], widths[i]);
    text += row.back() + "\n";
  }
  return text;
}

std::string markdown_row(const Row& row) { return fmt::format("| {} |\n", fmt::join(row, " | ")); }

}  // namespace

std::string keys_as_text(const std::string& prefix) {
  std::vector<Row> rows{kHeader};
  for (const Key& key : scene_keys()) {
    if (is_below(key, prefix)) rows.push_back(row_of(key, ""));
  }
  if (rows.size() > 1) return aligned(rows);
  const std::string nearest(nearest_key(scene_keys(), prefix));
  const std::string hint = nearest.empty() ? "; thenar keys lists all" : did_you_mean(nearest);
  throw ConfigError({{"keys " + printable(prefix), "", "unknown key" + hint}});
}

std::string keys_as_markdown() {
  const std::string header = markdown_row(kHeader) + "|---|---|---|---|---|\n";
  std::string page =
      "# The keys of a scene\n\n"
      "This page is written by `thenar keys --markdown`. `thenar keys contact` prints a part of it, and `thenar "
      "schema`\n"
      "the same as a JSON Schema, by which editors complete and check scenes.\n\n"
      "A number is followed by its unit; the first unit of a list is the SI unit. A range includes its ends, but for "
      "a 0\nbehind `>`. A key that has no default and is not required may be left out.\n\n" +
      header;
  for (const Key* key : keys_below(scene_keys(), "")) page += markdown_row(row_of(*key, "`"));
  for (const Key* map : keys_below(scene_keys(), "")) {
    if (keys_below(scene_keys(), map->path).empty()) continue;
    page += fmt::format("\n## {}\n\n{}\n\n{}", map->path, map->sentence, header);
    for (const Key& key : scene_keys()) {
      if (&key != map && is_below(key, map->path)) page += markdown_row(row_of(key, "`"));
    }
  }
  return page;
}

}  // namespace thenar::app
