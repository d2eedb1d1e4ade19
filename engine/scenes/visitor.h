// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <concepts>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "engine/scenes/keys.h"

namespace thenar {

/// Description of a key without its place in the file and the kind of its value, which follow from where and with
/// what it is shown to a Visitor. The fields are those of Key.
struct KeyRow {
  std::string_view name;
  Dimension dimension = Dimension::kNone;
  std::string_view range = "", without = "", sentence = "";
  LiveKey live = {};
};

/// Returns true if `without` is a sentence in brackets, unless this begins with "(Required".
[[nodiscard]] bool may_be_missing(const KeyRow& row);

/// Goes through a description of settings: a function describe(Visitor&, Settings&) that shows each key once with the
/// field that its value belongs to. There are four visitors. The table of keys (engine/scenes/key_table.cpp) notes the
/// rows and visits each branch, the reader (engine/scenes/config_reader.h) fills the fields from a file, the writer
/// (engine/scenes/config_writer.h) makes a file of them, and the window's live settings (app/window/live_settings.cpp)
/// read and change the few that may change in a run. What only some scenes have stands behind when(); what is wrong
/// between keys is refused where both are known. A description changes no field by itself unless the visitor reads.
/// A visitor that overrides nothing sees all that the settings have and does nothing.
class Visitor {
 public:
  virtual ~Visitor();

  /// Shows a value. Of a key that may be missing, a field that is zero or empty is not written.
  template <typename T>
  void key(const KeyRow& row, T& value) {
    if (!may_be_missing(row) || is_there(row.name, !is_zero(value))) show(row, value);
  }
  /// Shows a value that need not be there: nothing where it is missing, unless it is `required`.
  template <typename T>
  void key(const KeyRow& row, std::optional<T>& value, bool required = false) {
    if (!required && !is_there(row.name, value.has_value())) return value.reset();
    T now = value.value_or(zero<T>());
    show(row, now);
    value = now;
  }
  /// Shows one of the words of the row's range, each of which stands for the value of the same place in `values`.
  template <typename T>
  void choice(const KeyRow& row, T& value, const std::vector<T>& values) {
    const std::vector<std::string_view> words = words_of_choice(row.range);
    std::size_t i = 0;
    while (i + 1 < values.size() && !(values[i] == value)) ++i;
    const std::string chosen = choice_of(row, words[i]);
    for (i = 0; i + 1 < values.size() && words[i] != chosen;) ++i;
    value = values[i];
  }
  /// Shows one number a joint; for a hand without joints, which is the fault of another key, any number of them.
  virtual void per_joint(const KeyRow&, Eigen::VectorXd&, Eigen::Index joints);
  /// Returns the word that stands for the value or the map of this key, which is shown if there is none; `now`, if not
  /// empty, is written.
  [[nodiscard]] virtual std::string word(const KeyRow&, std::string_view now);

  /// Shows a map.
  template <typename Below>
  void map(const KeyRow& row, Below below) {
    enter(row, KeyKind::kMap);
    below();
    leave();
  }
  /// Shows a map that need not be there.
  template <typename T, typename Below>
  void map(const KeyRow& row, std::optional<T>& value, Below below) {
    if (!is_there(row.name, value.has_value())) return value.reset();
    T now = value ? *value : T{};
    map(row, [&] { below(now); });
    value = now;
  }
  /// Shows a value, or a map in its place; `as_map`: only the map can say what the settings have.
  template <typename T, typename Below>
  void value_or_map(const KeyRow& row, T& value, bool as_map, Below below) {
    if (may_be_missing(row) && !is_there(row.name, as_map || !is_zero(value))) return;
    const bool has_map = is_map(row.name, as_map);
    if (when(!has_map)) show(row, value);
    if (!when(has_map)) return;
    enter_in_place(row);
    below();
    leave();
  }
  /// Shows a map of which one key, that of chooses(), is there.
  template <typename Below>
  void one_of(const KeyRow& row, Below below) {
    enter(row, KeyKind::kOneOf);
    below();
    leave();
  }
  /// Returns true if this key is the one; `now`: it is in the settings.
  [[nodiscard]] virtual bool chooses(std::string_view name, bool now);
  /// Returns the alternative of a variant that a key stands for, made if it is chosen; null: another one is.
  template <typename T, typename Variant>
  [[nodiscard]] T* chosen(std::string_view name, Variant& variant) {
    if (!chooses(name, std::holds_alternative<T>(variant))) return nullptr;
    if (!std::holds_alternative<T>(variant)) variant = T{};
    return &std::get<T>(variant);
  }
  /// Shows a list of maps.
  template <typename T, typename Below>
  void list(const KeyRow& row, std::vector<T>& items, Below below) {
    if (may_be_missing(row) && !is_there(row.name, !items.empty())) return;
    items.resize(begin_list(row, items.size()));
    for (std::size_t i = 0; i < items.size(); ++i) {
      begin_item(row, i);
      below(items[i]);
      leave();
    }
    end_list();
  }

  /// Returns true if keys that only some scenes have are to be shown; always true for the table of keys.
  [[nodiscard]] virtual bool when(bool has_it) const;
  /// Returns true if a key of the current map, or of maps below it ("hand.slides"), is there; `now`: in the settings.
  [[nodiscard]] virtual bool is_there(std::string_view name, bool now);

  // Functions of the reader; without effect in the others.
  [[nodiscard]] virtual bool reads() const;
  /// Returns true if the file has the key.
  [[nodiscard]] virtual bool has(std::string_view);
  /// These work as in ConfigMap.
  virtual void refuse(std::string_view, std::string_view);
  [[nodiscard]] virtual bool is_refused(std::string_view);
  virtual void use_default(std::string_view, std::string_view);
  [[nodiscard]] virtual std::string location(std::string_view);

 protected:
  virtual void number(const KeyRow&, double&);
  virtual void numbers(const KeyRow&, Eigen::Ref<Eigen::VectorXd>);
  virtual void count(const KeyRow&, Eigen::Index&);
  virtual void rotation(const KeyRow&, Eigen::Matrix3d&);
  virtual void flag(const KeyRow&, bool&);
  virtual void text(const KeyRow&, std::string&);
  virtual void texts(const KeyRow&, std::vector<std::string>&);
  virtual void path(const KeyRow&, std::filesystem::path&);
  virtual std::string choice_of(const KeyRow&, std::string_view now);
  virtual void enter(const KeyRow&, KeyKind);
  /// Returns true if a map stands in the place of a value; `now`: in the settings.
  [[nodiscard]] virtual bool is_map(std::string_view name, bool now);
  /// Enters such a map.
  virtual void enter_in_place(const KeyRow&);
  /// Returns the number of items.
  [[nodiscard]] virtual std::size_t begin_list(const KeyRow&, std::size_t now);
  virtual void begin_item(const KeyRow&, std::size_t i);
  virtual void end_list();
  virtual void leave();

  /// Returns the words of the range of a choice.
  [[nodiscard]] static std::vector<std::string_view> words_of_choice(std::string_view range);

 private:
  template <typename T>
  static T zero() {
    if constexpr (requires { T::Zero(); }) {
      return T::Zero();
    } else {
      return T{};
    }
  }
  template <typename T>
  static bool is_zero(const T& value) {
    return value == zero<T>();
  }

  void show(const KeyRow& row, double& value) { number(row, value); }
  void show(const KeyRow& row, Eigen::Vector4d& value) { numbers(row, value); }
  void show(const KeyRow& row, Eigen::Vector3d& value) { numbers(row, value); }
  void show(const KeyRow& row, Eigen::Vector2d& value) { numbers(row, value); }
  void show(const KeyRow& row, Eigen::Index& value) { count(row, value); }
  void show(const KeyRow& row, Eigen::Matrix3d& value) { rotation(row, value); }
  void show(const KeyRow& row, bool& value) { flag(row, value); }
  void show(const KeyRow& row, std::string& value) { text(row, value); }
  void show(const KeyRow& row, std::vector<std::string>& value) { texts(row, value); }
  void show(const KeyRow& row, std::filesystem::path& value) { path(row, value); }
  template <std::integral T>
  void show(const KeyRow& row, T& value) {
    Eigen::Index wide = value;
    count(row, wide);
    value = static_cast<T>(wide);
  }
};

}  // namespace thenar
