// SPDX-License-Identifier: Apache-2.0
#include "engine/scenes/yaml_tree.h"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/mark.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <map>
#include <optional>
#include <sstream>
#include <utility>

#include "engine/formats/text.h"
#include "engine/scenes/yaml_syntax.h"

namespace thenar {

namespace {

using Kind = YamlNode::Kind;

/// Builds the nodes of one document from the parser's events.
class TreeBuilder : public YAML::EventHandler {
 public:
  TreeBuilder(std::size_t source, std::vector<YamlFault>& faults) : source_(source), faults_(faults) {}

  [[nodiscard]] std::unique_ptr<YamlNode> take_root() { return std::move(root_); }
  [[nodiscard]] bool has_quotes() const { return has_quotes_; }

  void OnDocumentStart(const YAML::Mark& /*mark*/) override {}
  void OnDocumentEnd() override {}

  void OnNull(const YAML::Mark& mark, YAML::anchor_t /*anchor*/) override { add(Kind::kNull, mark, ""); }

  void OnAlias(const YAML::Mark& mark, YAML::anchor_t /*anchor*/) override {
    faults_.push_back({place_of(mark), "", kNoAliases});
    add(Kind::kNull, mark, "");
  }

  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t /*anchor*/,
                const std::string& value) override {
    add(Kind::kScalar, mark, tag).text = value;
    has_quotes_ = has_quotes_ || tag == "!";
  }

  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t /*anchor*/,
                       YAML::EmitterStyle::value /*style*/) override {
    open_.push_back(&add(Kind::kList, mark, tag));
  }

  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t /*anchor*/,
                  YAML::EmitterStyle::value /*style*/) override {
    open_.push_back(&add(Kind::kMap, mark, tag));
  }

  void OnSequenceEnd() override { open_.pop_back(); }

  void OnMapEnd() override {
    YamlNode& map = *open_.back();
    open_.pop_back();
    // An open map holds its keys and values as items, in turn.
    std::vector<std::unique_ptr<YamlNode>> items = std::exchange(map.items, {});
    for (std::size_t i = 0; i + 1 < items.size(); i += 2) {
      const YamlNode& key = *items[i];
      if (key.kind != Kind::kScalar) faults_.push_back({key.place, "", "a key must be a word"});
      items[i + 1]->heading = key.place;
      map.entries.push_back({key.text, key.place, std::move(items[i + 1])});
    }
  }

 private:
  [[nodiscard]] Place place_of(const YAML::Mark& mark) const { return {source_, mark.line + 1, mark.column + 1}; }

  YamlNode& add(Kind kind, const YAML::Mark& mark, const std::string& tag) {
    auto node = std::make_unique<YamlNode>();
    node->kind = kind;
    node->place = node->heading = place_of(mark);
    // The parser tags plain values "?" or "" and quoted ones "!"; all else was written by the user.
    if (!tag.empty() && tag != "?" && tag != "!") {
      faults_.push_back({node->place, "", "tags are not read here: leave out " + tag});
    }
    YamlNode& added = *node;
    if (open_.empty()) {
      root_ = std::move(node);
    } else {
      open_.back()->items.push_back(std::move(node));
    }
    return added;
  }

  std::size_t source_;
  std::vector<YamlFault>& faults_;
  std::unique_ptr<YamlNode> root_;
  bool has_quotes_ = false;
  std::vector<YamlNode*> open_;
};

/// Reports a text that is no line of printable UTF-8: it would reach messages, results and names of files.
void report_text(const std::string& text, const Place& place, const std::string& path, std::vector<YamlFault>& faults) {
  const std::size_t bad = first_unprintable(text);
  if (bad == text.npos) return;
  const auto byte = static_cast<unsigned char>(text[bad]);
  const bool control = byte < 0x20 || byte == 0x7F;
  faults.push_back({place, path,
                    fmt::format("'{}' must be one line of text in UTF-8, without {} 0x{:02X}", printable(text),
                                control ? "the control character" : "byte", byte)});
}

/// Reports all such texts, and keys that are there twice.
void report_faults(const YamlNode& node, const std::string& path, std::vector<YamlFault>& faults) {
  report_text(node.text, node.place, path, faults);
  for (std::size_t i = 0; i < node.items.size(); ++i) report_faults(*node.items[i], item_path(path, i), faults);
  std::map<std::string_view, int> lines;
  for (const YamlNode::Entry& entry : node.entries) {
    const std::string entry_path = key_path(path, entry.key);
    report_text(entry.key, entry.place, entry_path, faults);
    const auto [first, is_new] = lines.emplace(entry.key, entry.place.line);
    if (!is_new) {
      faults.push_back({entry.place, entry_path, fmt::format("this key is already in line {}", first->second)});
    }
    report_faults(*entry.value, entry_path, faults);
  }
}

}  // namespace

YamlNode* YamlNode::find(std::string_view key) const {
  const auto entry = std::ranges::find(entries, key, &Entry::key);
  return entry == entries.end() ? nullptr : entry->value.get();
}

std::string key_path(std::string_view path, std::string_view key) {
  return path.empty() ? std::string(key) : std::string(path).append(".").append(key);
}

std::string item_path(std::string_view path, std::size_t index) {
  return std::string(path).append("[").append(std::to_string(index)).append("]");
}

std::unique_ptr<YamlNode> read_yaml(const std::string& text, std::size_t source, std::vector<YamlFault>& faults) {
  std::istringstream stream(text);
  TreeBuilder builder(source, faults);
  try {
    YAML::Parser parser(stream);
    parser.HandleNextDocument(builder);
    std::unique_ptr<YamlNode> root = builder.take_root();
    if (const auto open = builder.has_quotes() ? unclosed_quotes(text) : std::nullopt) {
      faults.push_back({{source, open->line, open->column}, "", open->message});
      return nullptr;
    }
    if (parser.HandleNextDocument(builder)) {
      faults.push_back({builder.take_root()->place, "", "a second document is not read: leave out the line '---'"});
      return nullptr;
    }
    if (root) report_faults(*root, "", faults);
    return root;
  } catch (const YAML::Exception& error) {
    const YAML::Mark mark = error.mark.is_null() ? YAML::Mark() : error.mark;
    const SyntaxFault fault = syntax_fault(text, mark.line + 1, mark.column + 1, error.msg);
    faults.push_back({{source, fault.line, fault.column}, "", fault.message});
    return nullptr;
  }
}

}  // namespace thenar
