// SPDX-License-Identifier: Apache-2.0
#include "engine/scenes/key_table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "engine/scenes/describe.h"
#include "engine/scenes/hand_keys.h"

namespace thenar {

namespace {

using enum KeyKind;

/// Notes the row of each key that a description shows.
class KeyTable final : public Visitor {
 public:
  std::vector<Key> keys;

  void per_joint(const KeyRow& row, Eigen::VectorXd&, Eigen::Index) override { add(row, kQuantities, kPerJoint); }
  std::string word(const KeyRow&, std::string_view) override { return ""; }
  bool chooses(std::string_view, bool) override { return true; }
  [[nodiscard]] bool when(bool) const override { return true; }
  bool is_there(std::string_view, bool) override { return true; }

 private:
  void number(const KeyRow& row, double&) override { add(row, kQuantity); }
  void numbers(const KeyRow& row, Eigen::Ref<Eigen::VectorXd> values) override {
    add(row, kQuantities, static_cast<int>(values.size()));
  }
  void count(const KeyRow& row, Eigen::Index&) override { add(row, kCount); }
  void rotation(const KeyRow& row, Eigen::Matrix3d&) override { add(row, kRotation); }
  void flag(const KeyRow& row, bool&) override { add(row, kFlag); }
  void text(const KeyRow& row, std::string&) override { add(row, kText); }
  void texts(const KeyRow& row, std::vector<std::string>&) override { add(row, kTexts); }
  void path(const KeyRow& row, std::filesystem::path&) override { add(row, kPath); }
  std::string choice_of(const KeyRow& row, std::string_view now) override {
    add(row, kChoice);
    return std::string(now);
  }
  void enter(const KeyRow& row, KeyKind kind) override {
    add(row, kind);
    maps_.emplace_back(row.name);
  }
  bool is_map(std::string_view, bool) override { return true; }
  void enter_in_place(const KeyRow& row) override { maps_.emplace_back(row.name); }
  std::size_t begin_list(const KeyRow& row, std::size_t) override {
    add(row, kMaps);
    return 1;
  }
  void begin_item(const KeyRow& row, std::size_t) override { maps_.emplace_back(row.name); }
  void leave() override { maps_.pop_back(); }

  void add(const KeyRow& row, KeyKind kind, int items = 1) {
    const std::string path = fmt::format("{}{}{}", fmt::join(maps_, "."), maps_.empty() ? "" : ".", row.name);
    keys.push_back({path, kind, row.dimension, row.range, row.without, row.sentence, items, row.live});
  }

  std::vector<std::string_view> maps_;
};

template <typename Described>
std::vector<Key> keys_of_description() {
  KeyTable table;
  Described described;
  describe(table, described);
  return table.keys;
}

}  // namespace

Keys scene_keys() {
  static const std::vector<Key> keys = keys_of_description<SceneFile>();
  return keys;
}

Keys hand_keys() {
  static const std::vector<Key> keys = keys_of_description<HandKeys>();
  return keys;
}

}  // namespace thenar
