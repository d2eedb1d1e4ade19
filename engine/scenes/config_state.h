// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "engine/scenes/keys.h"
#include "engine/scenes/yaml_tree.h"

/// What the readers of config.h share: a file's tree, its faults, and the values of the command line.
namespace thenar {

/// All that is known of a file.
struct ConfigState {
  std::filesystem::path file;
  Keys keys;
  std::vector<std::string> override_keys;
  std::unique_ptr<YamlNode> root;
  std::vector<std::unique_ptr<YamlNode>> defaults;  ///< Those that were taken, as if the file had them.
  std::vector<YamlFault> faults;
  std::vector<std::string> defaults_used;
  int unknown_keys = 0;

  void report(const Place& place, std::string key, std::string message) {
    faults.push_back({place, std::move(key), std::move(message)});
  }

  [[nodiscard]] std::string location(const Place& place) const;
};

/// The beginnings of faults that follow from others.
inline constexpr const char* kMissing = "this key is missing";
inline constexpr const char* kNeedsOne = "needs one of ";

/// Returns the path that the table has for one of the file: without the numbers of list items.
[[nodiscard]] std::string table_path(std::string_view path);

/// Adds values "key.path=value" to the tree; "list[0].key=value" to a list's map. The maps on their way are made where
/// they are missing.
void apply_overrides(ConfigState& state, const std::vector<std::string>& overrides);

/// Reports keys that no reader asked for.
void report_unused_keys(ConfigState& state, const YamlNode& node, const std::string& path);

}  // namespace thenar
