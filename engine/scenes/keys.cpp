// SPDX-License-Identifier: Apache-2.0
#include "engine/scenes/keys.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <stdexcept>

#include "engine/formats/text.h"

namespace thenar {

namespace {

using enum KeyKind;

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

/// Another word for a key's name, and how that is written where the two differ in more than their names.
struct OtherWord {
  std::string_view word, name, how = "";
};
constexpr OtherWord kOtherWords[]{
    {"diameter", "radius", " (half the diameter)"},
    {"radius", "diameter", " (twice the radius)"},
    {"capsule", "superquadric", ": a capsule is nearly {size: [24 mm, 24 mm, 90 mm], exponents: [0.2, 1]}"},
    {"ball", "sphere"},
    {"cube", "box"},
    {"block", "box"},
    {"mesh", "cloud"},
    {"file", "cloud"},
    {"height", "length"},
    {"length", "height"},
    {"weight", "mass"},
    {"orientation", "rotation"},
    {"direction", "down"},
    {"rpy", "euler"},
    {"mu", "friction"},
};

}  // namespace

const Key* find_key(Keys keys, std::string_view path) {
  const auto found = std::ranges::find(keys, path, &Key::path);
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
    return nearest.empty() ? std::string_view() : (*found)->path;
  };
  const std::string_view parent = parent_of(path);
  const std::vector<const Key*> siblings = keys_below(keys, parent);
  const std::string_view sibling = nearest_among(siblings);
  if (!sibling.empty()) return sibling;
  for (const OtherWord& other : kOtherWords) {
    const auto same = std::ranges::find(siblings, other.name, [](const Key* key) { return name_of(*key); });
    if (other.word == name && same != siblings.end()) return (*same)->path;
  }
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

std::string_view how_to_write(std::string_view word, std::string_view name) {
  const auto other = std::ranges::find(kOtherWords, word, &OtherWord::word);
  return other == std::end(kOtherWords) || other->name != name ? "" : other->how;
}

bool has_default(const Key& key) { return !key.without.empty() && !key.without.starts_with('('); }

bool is_required(Keys keys, const Key& key) {
  const Key* const parent = find_key(keys, parent_of(key.path));
  return key.without.empty() && (parent == nullptr || parent->kind != kOneOf);
}

bool may_be_map(Keys keys, const Key& key) {
  const bool is_value = key.kind == kQuantities || key.kind == kRotation || key.kind == kPath;
  return is_value && !keys_below(keys, key.path).empty();
}

Range range_of(const Key& key) {
  const std::string_view text = key.kind == kChoice ? "" : split(key.range, " | ").front();
  const std::vector<std::string_view> ends = split(text, " .. ");
  Range range;
  if (!text.empty()) range.least_text = ends.front();
  if (ends.size() == 2) range.most_text = ends[1];
  range.open = range.least_text.starts_with("> ");
  const bool is_behind = range.open || range.least_text.starts_with(">= ");
  if (is_behind) range.least_text.remove_prefix(range.open ? 2 : 3);
  if (!text.empty() && !is_behind && ends.size() < 2) throw std::logic_error(fmt::format("range of {}", key.path));
  if (key.kind == kQuantity || key.kind == kQuantities) {
    if (range.least_text.empty()) range.least_text = least_of(key.dimension);
    if (range.most_text.empty()) range.most_text = most_of(key.dimension);
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
  if (key.range.starts_with(">= ") && range.least == 0.0 && value < 0.0)
    return fmt::format("{} must not be negative", text);
  if (value < range.least) return fmt::format("{} must be at least {}", text, range.least_text);
  if (value > range.most) return fmt::format("{} must be at most {}", text, range.most_text);
  return "";
}

}  // namespace thenar
