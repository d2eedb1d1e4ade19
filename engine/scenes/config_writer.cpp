// SPDX-License-Identifier: Apache-2.0
#include "engine/scenes/config_writer.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <iterator>
#include <list>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/formats/text.h"

namespace thenar {

namespace {

/// A text as YAML reads it back: in quotes unless it is a plain word.
std::string yaml_word(const std::string& text) {
  const auto is_plain = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-'; };
  const bool is_word = !text.empty() && std::isalpha(static_cast<unsigned char>(text.front())) != 0 &&
                       std::ranges::all_of(text, is_plain);
  std::string small = text;
  for (char& c : small) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  constexpr std::string_view kReserved[]{"null", "true", "false", "yes", "no", "on", "off"};
  return is_word && std::ranges::find(kReserved, small) == std::end(kReserved) ? text : quoted(text);
}

class ConfigWriter final : public Visitor {
 public:
  explicit ConfigWriter(const Hand* hand) : hand_(hand), open_{&root_} {}

  [[nodiscard]] std::string text() const {
    std::string out;
    for (const Node& node : root_.below) out += yaml_comment(std::string(node.heading)) + block(node, "");
    return out;
  }

  void per_joint(const KeyRow& row, Eigen::VectorXd& values, Eigen::Index) override {
    Node& node = add(row);
    for (const Fingertip& tip : hand_->fingertips) {
      const std::string of_finger =
          to_text(Eigen::VectorXd(values.segment(tip.first_joint, tip.joints)), row.dimension);
      node.rows.push_back({of_finger.substr(1, of_finger.size() - 2), tip.finger});
    }
  }
  std::string word(const KeyRow& row, std::string_view now) override {
    if (!now.empty()) add(row).text = now;
    return std::string(now);
  }
  bool chooses(std::string_view, bool now) override { return now; }
  bool is_there(std::string_view, bool now) override { return now; }

 private:
  struct Row {
    std::string text, note = {};
  };
  struct Node {
    enum Kind { kValue, kMap, kList };
    Kind kind = kValue;
    std::string_view key, heading;
    std::string text = {};
    std::vector<Row> rows = {};  ///< Of a list of numbers that is written in several lines.
    std::list<Node> below = {};
  };

  void number(const KeyRow& row, double& value) override { add_value(row, to_text(value, row.dimension)); }
  void numbers(const KeyRow& row, Eigen::Ref<Eigen::VectorXd> values) override {
    add_value(row, to_text(Eigen::VectorXd(values), row.dimension));
  }
  void count(const KeyRow& row, Eigen::Index& value) override { add_value(row, std::to_string(value)); }
  void rotation(const KeyRow& row, Eigen::Matrix3d& value) override {
    constexpr std::size_t kShort = 60;
    Node& node = add(row);
    for (int i = 0; i < 3; ++i) node.rows.push_back({to_text(Eigen::VectorXd(value.row(i)), row.dimension)});
    const std::string in_line = fmt::format("[{}, {}, {}]", node.rows[0].text, node.rows[1].text, node.rows[2].text);
    if (in_line.size() > kShort) return;
    node.text = in_line;
    node.rows.clear();
  }
  void flag(const KeyRow& row, bool& value) override { add_value(row, value ? "true" : "false"); }
  void text(const KeyRow& row, std::string& value) override {
    Node& node = add(row);
    node.text = yaml_word(value);
    node.heading = "";
  }
  void texts(const KeyRow& row, std::vector<std::string>& value) override {
    std::vector<std::string> items;
    for (const std::string& item : value) items.push_back(yaml_word(item));
    add_value(row, fmt::format("[{}]", fmt::join(items, ", ")));
  }
  void path(const KeyRow& row, std::filesystem::path& value) override { add_value(row, quoted(value.string())); }
  std::string choice_of(const KeyRow& row, std::string_view now) override {
    add_value(row, std::string(now));
    return std::string(now);
  }
  void enter(const KeyRow& row, KeyKind) override {
    Node& node = add(row);
    node.kind = Node::kMap;
    open_.push_back(&node);
  }
  std::size_t begin_list(const KeyRow& row, std::size_t now) override {
    Node& node = add(row);
    node.kind = Node::kList;
    open_.push_back(&node);
    return now;
  }
  void begin_item(const KeyRow&, std::size_t) override {
    open_.push_back(&open_.back()->below.emplace_back(Node{.kind = Node::kMap, .key = "", .heading = ""}));
  }
  /// A part of the file of which nothing is to be said is left out. A map within one may say something by being there.
  void leave() override {
    open_.pop_back();
    if (open_.back() == &root_ && root_.below.back().below.empty()) root_.below.pop_back();
  }
  void end_list() override { leave(); }

  Node& add(const KeyRow& row) {
    return open_.back()->below.emplace_back(Node{.key = row.name, .heading = row.sentence});
  }
  /// A value that a file has without naming it is left out.
  void add_value(const KeyRow& row, std::string text) {
    if (text != row.without) add(row).text = std::move(text);
  }

  static bool is_short(const Node& node) {
    return node.rows.empty() && node.kind != Node::kList && std::ranges::all_of(node.below, is_short);
  }
  static std::string line(const Node& node) {
    if (node.kind == Node::kValue) return node.text;
    std::vector<std::string> entries;
    for (const Node& one : node.below) entries.push_back(fmt::format("{}: {}", one.key, line(one)));
    return fmt::format("{{{}}}", fmt::join(entries, ", "));
  }
  static std::string rows(const Node& node, std::size_t indent) {
    std::string text = "[";
    for (const Row& row : node.rows) {
      const bool is_last = &row == &node.rows.back();
      if (&row != &node.rows.front()) text += std::string(indent + 1, ' ');
      text += row.text + (is_last ? "]" : ",") + (row.note.empty() ? "" : "  # " + row.note) + (is_last ? "" : "\n");
    }
    return text;
  }
  /// The node in lines of its own, each of which begins with `indent`.
  static std::string block(const Node& node, const std::string& indent) {
    constexpr std::size_t kColumns = 118;
    const std::string key = fmt::format("{}{}:", indent, node.key);
    if (!node.rows.empty()) return key + " " + rows(node, key.size() + 1) + "\n";
    const bool is_in_line = node.kind == Node::kValue || (is_short(node) && !indent.empty());
    if (is_in_line && (node.kind == Node::kValue || key.size() + line(node).size() < kColumns)) {
      return key + " " + line(node) + "\n";
    }
    std::string text = key + "\n";
    for (const Node& one : node.below) text += node.kind == Node::kList ? item(one, indent) : block(one, indent + "  ");
    return text;
  }
  static std::string item(const Node& node, const std::string& indent) {
    if (is_short(node)) return fmt::format("{}  - {}\n", indent, line(node));
    std::string text;
    for (const Node& one : node.below) text += block(one, indent + "    ");
    return text.replace(indent.size() + 2, 1, "-");
  }

  const Hand* hand_;
  Node root_{.kind = Node::kMap, .key = "", .heading = ""};
  std::vector<Node*> open_;
};

}  // namespace

std::string yaml_comment(const std::string& words) {
  std::string result, line = "#";
  std::size_t at = 0;
  while (at < words.size()) {
    const std::size_t end = std::min(words.find(' ', at), words.size());
    if (line.size() + 1 + end - at > 118) {
      result += line + "\n";
      line = "#";
    }
    line += " " + words.substr(at, end - at);
    at = end + 1;
  }
  return words.empty() ? "" : result + line + "\n";
}

std::string config_text(const std::function<void(Visitor&)>& show, const Hand* hand) {
  ConfigWriter writer(hand);
  show(writer);
  return writer.text();
}

}  // namespace thenar
