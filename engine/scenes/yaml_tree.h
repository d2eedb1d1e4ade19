// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <compare>
#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace thenar {

/// Place of a value: in the file (source 0), or in the `source`th value of the command line.
struct Place {
  std::size_t source = 0;
  int line = 1;
  int column = 1;
  auto operator<=>(const Place&) const = default;
};

/// One value of a YAML document with its place. Keys keep their order.
struct YamlNode {
  enum class Kind { kNull, kScalar, kList, kMap };
  struct Entry {
    std::string key;
    Place place;  ///< Place of the key.
    std::unique_ptr<YamlNode> value;
  };

  Kind kind = Kind::kNull;
  Place place;
  Place heading;                                 ///< Place of its key, or its own where it has none.
  std::string text;                              ///< Text of a scalar.
  std::vector<std::unique_ptr<YamlNode>> items;  ///< Items of a list.
  std::vector<Entry> entries;                    ///< Entries of a map.

  // Parts of a map that the readers of config.h have seen.
  bool was_entered = false;
  std::vector<std::string> asked_keys;

  [[nodiscard]] YamlNode* find(std::string_view key) const;
};

/// Fault of a document as YAML.
struct YamlFault {
  Place place;
  std::string key;
  std::string message;
};

/// Return the full path of a map's key, "object.mass", and of a list's item, "gravity[2]".
[[nodiscard]] std::string key_path(std::string_view path, std::string_view key);
[[nodiscard]] std::string item_path(std::string_view path, std::size_t index);

/// Reads one YAML document. Beyond broken syntax, doubled keys, keys that are no words, aliases, tags, a second
/// document and texts that are no line of printable UTF-8 are faults, added to `faults`. Null if there is no document,
/// or a second one, or its syntax is broken.
[[nodiscard]] std::unique_ptr<YamlNode> read_yaml(const std::string& text, std::size_t source,
                                                  std::vector<YamlFault>& faults);

}  // namespace thenar
