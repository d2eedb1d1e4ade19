// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/scenes/units.h"

/// Tables of keys, which the readers of config.h check. Those of scenes and of hand files, which `thenar keys`,
/// docs/reference/scene.md and the JSON schema show, are in engine/scenes/key_table.h.
namespace thenar {

enum class KeyKind {
  kMap,         ///< Keys below this one.
  kOneOf,       ///< A map with exactly one of the keys below.
  kMaps,        ///< A list of maps.
  kQuantity,    ///< A number with a unit of the dimension.
  kQuantities,  ///< A list of `items` of them, or of one for each joint of the hand. With keys below, it may be a map.
  kCount,       ///< A whole number.
  kRotation,    ///< A rotation matrix: three rows of three numbers. With keys below, it may be a map.
  kText,
  kTexts,  ///< A list of any length but zero.
  kPath,   ///< A file, relative to the folder of the file that names it. With keys below, it may be a map.
  kFlag,   ///< true or false
  kChoice  ///< One of the range's words.
};

inline constexpr int kPerJoint = 0;

/// Change of a key in the window while its scene runs: docs/reference/window.md.
struct LiveKey {
  std::string_view name;   ///< In messages, as "contact_Hz"; empty: it cannot be changed.
  std::string_view label;  ///< For people: "contact rate".
  /// Unit of the message's number: the SI one, or for a time "Hz" (its reciprocal) or "periods" (a number of control
  /// periods); empty: a plain number.
  std::string_view unit;
  /// Range of the number, or of each number; for a choice with a range the number is the place of its word. Both 0:
  /// one of the words of a choice.
  double least = 0.0, most = 0.0;
  bool whole = false;  ///< True for a whole number.
};

struct Key {
  std::string path;  ///< As "contact.friction"; in lists of maps without the number: "joints.name".
  KeyKind kind;
  Dimension dimension;
  /// Allowed values. Numbers: "> 0", ">= 1 kPa", "0 .. 10 mm" or "> 0 .. 10", ends included but for one behind ">", a
  /// bare 0 in any unit; where an end is missing it is that of the dimension. Then, each behind a bar, the words that
  /// may stand for a number: "> 0 | auto". Maps: the words that may stand for one, each
  /// behind a bar; choices: the words alone. Empty: all that the kind allows.
  std::string_view range;
  /// Default without the key: a value, which is then read, or a sentence in brackets. Empty: the key must be there.
  std::string_view without;
  std::string_view sentence;  ///< Meaning of the key.
  int items = 1;              ///< Number of kQuantities, or kPerJoint.
  LiveKey live = {};
};

using Keys = std::span<const Key>;  ///< A table: each key after the one above it.

/// Returns the key, or null if the table has none such.
[[nodiscard]] const Key* find_key(Keys keys, std::string_view path);
/// Return the last name of a path, and the path before it: "friction" and "contact".
[[nodiscard]] std::string_view name_of(const Key& key);
[[nodiscard]] std::string_view parent_of(std::string_view path);
/// Returns the keys one step below a path; those of the whole table for "".
[[nodiscard]] std::vector<const Key*> keys_below(Keys keys, std::string_view path);
/// Returns the names of keys_below().
[[nodiscard]] std::vector<std::string_view> names_below(Keys keys, std::string_view path);

/// Returns the path that an unknown one may be a slip of: a key of the same map with a similar name or, of other words
/// for it, the one that is used here; else one of another map with the same name; where the table has no such map, one
/// anywhere that is similar. Empty if none is near.
[[nodiscard]] std::string_view nearest_key(Keys keys, std::string_view path);

/// Returns how the value of a word is written under the name that is used here; mostly nothing.
[[nodiscard]] std::string_view how_to_write(std::string_view word, std::string_view name);

/// Returns true if the key has a value where the file does not name it.
[[nodiscard]] bool has_default(const Key& key);
/// Returns true if every map that may hold the key must hold it.
[[nodiscard]] bool is_required(Keys keys, const Key& key);
/// Returns true if the key is a value that a map may replace.
[[nodiscard]] bool may_be_map(Keys keys, const Key& key);

/// Bounds in SI and as written. Only keys that are no numbers have none.
struct Range {
  double least = -std::numeric_limits<double>::infinity();
  double most = std::numeric_limits<double>::infinity();
  bool open = false;  ///< True if `least` itself is excluded.
  std::string_view least_text, most_text;
};

/// Returns the range of a key of numbers. Throws std::logic_error if the table is wrong.
[[nodiscard]] Range range_of(const Key& key);
/// Returns the words that the key may be.
[[nodiscard]] std::vector<std::string_view> words_of(const Key& key);

/// Returns the fault of a number with this SI value and text: "-1 mm must be greater than zero"; empty if it is in
/// the range.
[[nodiscard]] std::string range_fault(const Key& key, double value, std::string_view text);

}  // namespace thenar
