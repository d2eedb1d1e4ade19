// SPDX-License-Identifier: Apache-2.0
#include "engine/scenes/config_state.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <sstream>
#include <utility>

#include "engine/formats/text.h"

namespace thenar {

using Kind = YamlNode::Kind;

namespace {

std::unique_ptr<YamlNode> make_node(Kind kind, const Place& place) {
  auto node = std::make_unique<YamlNode>();
  node->kind = kind;
  node->place = node->heading = place;
  return node;
}

/// The n of a key "list[n]", which is cut off; nothing of others.
std::optional<std::size_t> take_index(std::string& key) {
  const std::size_t bracket = key.find('[');
  std::size_t index = 0;
  if (bracket == key.npos) return std::nullopt;
  std::from_chars(key.data() + bracket + 1, key.data() + key.size(), index);
  if (item_path(key.substr(0, bracket), index) != key) return std::nullopt;  // "[]", "[00]", "[1e99]"
  key.resize(bracket);
  return index;
}

/// Takes the next text of the command line, and with it what the shell has parted from it at blanks about its '='.
/// `is_parted` tells that there were such.
std::string take_override(const std::vector<std::string>& overrides, std::size_t& next, bool& is_parted) {
  std::string text = overrides[next++];
  is_parted = false;
  while (next < overrides.size() && (overrides[next].starts_with('=') ||
                                     (text.ends_with('=') && overrides[next].find('=') == std::string::npos))) {
    text += overrides[next++];
    is_parted = true;
  }
  return text;
}

/// Puts a map in the place of a word that stands for one, as `auto` of `grasp: auto`. False if it is none.
bool take_word_for_map(ConfigState& state, const std::string& path, YamlNode& node) {
  const Key* const key = find_key(state.keys, table_path(path));
  if (key == nullptr || key->kind != KeyKind::kMap || node.kind != Kind::kScalar) return false;
  const std::vector<std::string_view> words = words_of(*key);
  if (std::ranges::find(words, node.text) == words.end()) return false;
  node.kind = Kind::kMap;
  node.text.clear();
  return true;
}

/// How to set a key below one that has a value, where a map may stand in its place; nothing elsewhere.
std::string whole_map(const ConfigState& state, const std::string& above, const std::string& path,
                      const std::string& value) {
  const Key* const key = find_key(state.keys, table_path(above));
  if (key == nullptr || !may_be_map(state.keys, *key)) return "";
  return fmt::format(": write the whole of it, as in --set '{}={{{}: {}}}'", above, path.substr(above.size() + 1),
                     value);
}

/// Adds "key.path=value", the next text of the command line, to the tree; "list[0].key=value" to a list's map. The maps
/// on its way are made where they are missing.
void apply_override(ConfigState& state, const std::vector<std::string>& overrides, std::size_t& next) {
  bool is_parted = false;
  const std::string override_text = take_override(overrides, next, is_parted);
  const std::size_t equals = override_text.find('=');
  const std::string path = override_text.substr(0, equals);
  state.override_keys.push_back(path);
  const Place place{state.override_keys.size()};
  const bool has_empty_key = path.empty() || path.front() == '.' || path.back() == '.' || path.find("..") != path.npos;
  if (equals == std::string::npos || has_empty_key) {
    return state.report(place, "", "write it as key=value, such as time.step=0.5 ms");
  }
  if (is_parted) return state.report(place, "", "write it without blanks about the '=': '" + override_text + "'");
  auto value = read_yaml(override_text.substr(equals + 1), place.source, state.faults);
  if (!value) value = make_node(Kind::kNull, place);

  YamlNode* map = state.root.get();
  std::string so_far;
  std::istringstream keys(path);
  for (std::string key; std::getline(keys, key, '.');) {
    const std::optional<std::size_t> item = take_index(key);
    if (map->kind != Kind::kMap && !take_word_for_map(state, so_far, *map)) {
      const std::string how = whole_map(state, so_far, path, override_text.substr(equals + 1));
      return state.report(place, path, so_far + " is not a map of keys and values" + how);
    }
    so_far = key_path(so_far, key);
    auto entry = std::ranges::find(map->entries, key, &YamlNode::Entry::key);
    if (entry == map->entries.end() && item) return state.report(place, path, so_far + " is no list of the file");
    if (entry == map->entries.end()) {
      map->entries.push_back({key, place, make_node(Kind::kMap, place)});
      entry = map->entries.end() - 1;
    }
    std::unique_ptr<YamlNode>* slot = &entry->value;
    if (item) {
      so_far = item_path(so_far, *item);
      if ((*slot)->kind != Kind::kList || *item >= (*slot)->items.size()) {
        return state.report(place, path,
                            fmt::format("{} is not in the file's list, which has {}", so_far,
                                        counted(std::ssize((*slot)->items), "item")));
      }
      slot = &(*slot)->items[*item];
    }
    if (so_far == path) {
      value->heading = place;
      if (!item) entry->place = place;
      *slot = std::move(value);
      return;
    }
    map = slot->get();
  }
}

/// Takes back a fault that follows from another one.
void forget(ConfigState& state, const std::string& key, std::string_view message) {
  std::erase_if(state.faults, [&](const YamlFault& f) { return f.key == key && f.message.starts_with(message); });
}

/// Reports a key that no reader asked for: one that the table does not have, or that this scene has no use for.
void report_unused_key(ConfigState& state, const YamlNode::Entry& entry, const std::string& map_path) {
  const std::string map = table_path(map_path), path = key_path(map_path, entry.key);
  const std::vector<std::string_view> names = names_below(state.keys, map);
  if (std::ranges::find(names, entry.key) != names.end()) {
    state.report(entry.place, path, "has no effect here: leave it out");
    return;
  }
  if (entry.value->kind == Kind::kNull && entry.key.find_first_not_of("0123456789") == entry.key.npos) {
    return state.report(entry.place, path, "unknown key: the mark in a number is '.', not ','");
  }
  const std::string in_table = key_path(map, entry.key);
  if (find_key(state.keys, in_table) != nullptr) {
    state.report(entry.place, path, "in a file each name stands below the one before it, without dots");
    return;
  }
  forget(state, map_path, kNeedsOne);
  const std::string before_colon = entry.key.substr(0, entry.key.find(':'));
  if (before_colon != entry.key && find_key(state.keys, key_path(map, before_colon)) != nullptr) {
    forget(state, key_path(map_path, before_colon), kMissing);
    return state.report(entry.place, path, "write a blank behind the ':'");
  }
  // A file of another kind has thousands: no slips.
  constexpr int kMostSlips = 50;
  std::string meant;
  if (++state.unknown_keys <= kMostSlips) meant = nearest_key(state.keys, in_table);
  // Of the same map, which may be a list's item.
  if (!meant.empty() && parent_of(meant) == map) meant.replace(0, map.size(), map_path);
  const std::string instead(how_to_write(entry.key, std::string_view(meant).substr(meant.rfind('.') + 1)));
  const bool lists = meant.empty() && !map.empty() && !names.empty();
  const std::string others = lists ? "; known here: " + join(names, ", ") : "";
  state.report(entry.place, path, "unknown key" + did_you_mean(meant) + instead + others);
  // A key that is only misspelt is not missing besides.
  if (meant.empty()) return;
  forget(state, meant, kMissing);
}

}  // namespace

std::string table_path(std::string_view path) {
  std::string text;
  bool in_brackets = false;
  for (const char c : path) {
    if (c == '[') in_brackets = true;
    if (!in_brackets) text += c;
    if (c == ']') in_brackets = false;
  }
  return text;
}

std::string ConfigState::location(const Place& place) const {
  if (place.source > 0) return "--set " + override_keys[place.source - 1];
  return fmt::format("{}:{}:{}", file.string(), place.line, place.column);
}

void apply_overrides(ConfigState& state, const std::vector<std::string>& overrides) {
  for (std::size_t i = 0; i < overrides.size();) apply_override(state, overrides, i);
}

void report_unused_keys(ConfigState& state, const YamlNode& node, const std::string& path) {
  for (std::size_t i = 0; i < node.items.size(); ++i) report_unused_keys(state, *node.items[i], item_path(path, i));
  if (node.kind != Kind::kMap || !node.was_entered) return;
  for (const YamlNode::Entry& entry : node.entries) {
    if (std::ranges::find(node.asked_keys, entry.key) == node.asked_keys.end()) {
      report_unused_key(state, entry, path);
    } else {
      report_unused_keys(state, *entry.value, key_path(path, entry.key));
    }
  }
}

}  // namespace thenar
