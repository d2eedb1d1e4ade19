// SPDX-License-Identifier: Apache-2.0
#include "engine/scenes/config.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "engine/formats/files.h"
#include "engine/formats/text.h"
#include "engine/scenes/config_state.h"
#include "engine/scenes/value_hints.h"
#include "engine/scenes/yaml_syntax.h"

namespace thenar {

using Eigen::Index;
using Kind = YamlNode::Kind;

namespace {

constexpr std::array kKindNames{"nothing", "a single value", "a list", "a map"};  // In the order of Kind.

/// Whether `node` is of this kind; reports it otherwise.
bool expect_kind(ConfigState& state, const YamlNode& node, const std::string& path, Kind kind,
                 std::string_view wanted) {
  if (node.kind == kind) return true;
  // A value left out stands nowhere: its key does.
  const Place& place = node.kind == Kind::kNull ? node.heading : node.place;
  state.report(place, path,
               "must be " + std::string(wanted) + ", not " + kKindNames[static_cast<std::size_t>(node.kind)]);
  return false;
}

/// A value in the key's range, for after a fault.
double harmless(const Key& key) {
  const Range range = range_of(key);
  return std::clamp(1.0, range.least, range.most);
}

double quantity_of(ConfigState& state, const YamlNode& node, const std::string& path, const Key& key) {
  if (!expect_kind(state, node, path, Kind::kScalar, name_of(key.dimension))) return harmless(key);
  Quantity quantity = read_quantity(node.text, key.dimension);
  if (quantity.fault.empty()) quantity.fault = range_fault(key, quantity.value, node.text);
  if (quantity.fault.empty()) return quantity.value;
  state.report(node.place, path, std::move(quantity.fault));
  return harmless(key);
}

/// Whether `node` is a list of so many things; reports it otherwise.
bool expect_items(ConfigState& state, const YamlNode& node, const std::string& path, int count,
                  std::string_view things) {
  const std::string wanted = fmt::format("a list of {} {}", count, things);
  if (!expect_kind(state, node, path, Kind::kList, wanted)) return false;
  if (std::ssize(node.items) == count) return true;
  state.report(node.place, path,
               fmt::format("must be {}, not {}{}", wanted, node.items.size(), list_hint(node, count)));
  return false;
}

/// A list of quantities; nullopt after a fault in the list itself.
std::optional<Eigen::VectorXd> quantities_of(ConfigState& state, const YamlNode& node, const std::string& path,
                                             const Key& key, std::string_view things = "values") {
  if (!expect_items(state, node, path, key.items, things)) return std::nullopt;
  Eigen::VectorXd values(key.items);
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    values[static_cast<Index>(i)] = quantity_of(state, *node.items[i], item_path(path, i), key);
  }
  return values;
}

/// Throws ConfigError if there is any fault.
void throw_if_faulty(ConfigState& state) {
  std::vector<YamlFault>& faults = state.faults;
  if (faults.empty()) return;
  // A text of the command line that is no YAML has no value besides.
  const std::vector<YamlFault> all = faults;
  std::erase_if(faults, [&](const YamlFault& fault) {
    return fault.place.source > 0 && !fault.key.empty() && std::ranges::any_of(all, [&](const YamlFault& other) {
             return other.place.source == fault.place.source && other.key.empty();
           });
  });
  const auto order = [](const YamlFault& f) { return std::tie(f.place, f.key, f.message); };
  std::ranges::sort(faults, {}, order);
  std::vector<ConfigDiagnostic> diagnostics;
  for (std::size_t i = 0; i < faults.size(); ++i) {
    const auto& [place, key, message] = faults[i];
    // What two readers found is one fault.
    if (i > 0 && order(faults[i]) == order(faults[i - 1])) continue;
    diagnostics.push_back({state.location(place), key, message});
  }
  throw ConfigError(diagnostics);
}

}  // namespace

Config::Config(const std::filesystem::path& file, Keys keys, const std::vector<std::string>& overrides,
               const std::optional<std::string>& text)
    : state_(std::make_unique<ConfigState>()) {
  state_->file = file;
  state_->keys = keys;
  const std::string whole = text ? *text : read_file(file);
  state_->root = read_yaml(whole, 0, state_->faults);
  if (!state_->root && state_->faults.empty()) state_->report({}, "", "the file is empty");
  if (!state_->root) throw_if_faulty(*state_);
  if (state_->root->kind != Kind::kMap) state_->faults.clear();  // It is no YAML: nothing in it is to be mended.
  if (const auto fault = state_->root->kind == Kind::kMap ? std::nullopt : no_text(whole)) {
    state_->report({0, fault->line, fault->column}, "", fault->message);
    throw_if_faulty(*state_);
  }
  if (!expect_kind(*state_, *state_->root, "", Kind::kMap, "a map of keys and values")) throw_if_faulty(*state_);
  apply_overrides(*state_, overrides);
}

Config::~Config() = default;

ConfigMap Config::root() const {
  state_->root->was_entered = true;
  return {state_.get(), state_->root.get(), ""};
}

void Config::finish() {
  report_unused_keys(*state_, *state_->root, "");
  throw_if_faulty(*state_);
}

const std::vector<std::string>& Config::defaults_used() const noexcept { return state_->defaults_used; }

ConfigMap::ConfigMap(ConfigState* state, YamlNode* node, std::string path)
    : state_(state), node_(node), path_(std::move(path)) {}

std::string ConfigMap::location(std::string_view key) const {
  const YamlNode* const node = find(key);
  if (node == nullptr && node_ == nullptr) return "";
  return printable(state_->location(node == nullptr ? node_->heading : node->heading));
}

std::string ConfigMap::path_of(std::string_view key) const { return key_path(path_, key); }

const Key& ConfigMap::known(std::string_view key, std::optional<KeyKind> kind) const {
  const std::string path = table_path(path_of(key));
  const Key* const found = find_key(state_->keys, path);
  if (found == nullptr) throw std::logic_error("no key " + path + " in the table");
  if (kind && found->kind != *kind) throw std::logic_error(path + " is of another kind in the table");
  return *found;
}

YamlNode* ConfigMap::find(std::string_view key) const {
  (void)known(key);
  if (node_ == nullptr) return nullptr;
  if (std::ranges::find(node_->asked_keys, key) == node_->asked_keys.end()) node_->asked_keys.emplace_back(key);
  return node_->find(key);
}

YamlNode* ConfigMap::require(std::string_view key, std::optional<KeyKind> kind) const {
  const Key& missing = known(key, kind);
  YamlNode* const node = find(key);
  if (node != nullptr || node_ == nullptr) return node;
  if (!has_default(missing)) {
    state_->report(node_->heading, path_of(key), kMissing);
    return nullptr;
  }
  use_default(key, missing.without);
  state_->defaults.push_back(read_yaml(std::string(missing.without), 0, state_->faults));
  return state_->defaults.back().get();
}

bool ConfigMap::has(std::string_view key) const { return find(key) != nullptr; }

bool ConfigMap::is_map(std::string_view key) const {
  const YamlNode* const node = find(key);
  return node != nullptr && node->kind == Kind::kMap;
}

std::string ConfigMap::word(std::string_view key) const {
  const std::vector<std::string_view> words = words_of(known(key));
  const YamlNode* const node = find(key);
  const bool is_one = node != nullptr && std::ranges::find(words, node->text) != words.end();
  return is_one ? node->text : "";
}

double ConfigMap::quantity(std::string_view key) const {
  const Key& wanted = known(key, KeyKind::kQuantity);
  const YamlNode* const node = require(key);
  return node == nullptr ? harmless(wanted) : quantity_of(*state_, *node, path_of(key), wanted);
}

Eigen::VectorXd ConfigMap::quantities(std::string_view key) const {
  const Key& wanted = known(key, KeyKind::kQuantities);
  const YamlNode* const node = require(key);
  const auto values = node == nullptr ? std::nullopt : quantities_of(*state_, *node, path_of(key), wanted);
  return values.value_or(Eigen::VectorXd::Constant(wanted.items, harmless(wanted)));
}

Eigen::VectorXd ConfigMap::quantities(std::string_view key, std::size_t joints) const {
  Key wanted = known(key, KeyKind::kQuantities);
  const YamlNode* const node = require(key);
  const bool is_list = node != nullptr && node->kind == Kind::kList;
  wanted.items = static_cast<int>(joints == 0 && is_list ? node->items.size() : joints);
  const auto values = node == nullptr
                          ? std::nullopt
                          : quantities_of(*state_, *node, path_of(key), wanted, "values, one for each joint");
  return values.value_or(Eigen::VectorXd::Constant(static_cast<Index>(joints), harmless(wanted)));
}

Index ConfigMap::count(std::string_view key) const {
  const Key& wanted = known(key, KeyKind::kCount);
  const auto instead = static_cast<Index>(harmless(wanted));  // A range without a least has -inf, which is no Index.
  const YamlNode* const node = require(key);
  if (node == nullptr || !expect_kind(*state_, *node, path_of(key), Kind::kScalar, "a whole number")) return instead;
  Index value = 0;
  const char* const last = node->text.data() + node->text.size();
  const auto [end, error] = std::from_chars(node->text.data(), last, value);
  if (error == std::errc::invalid_argument || end != last) {
    state_->report(node->place, path_of(key), "'" + node->text + "' is not a whole number" + digits_hint(node->text));
    return instead;
  }
  if (error == std::errc::result_out_of_range) {
    value = node->text.starts_with('-') ? std::numeric_limits<Index>::min() : std::numeric_limits<Index>::max();
  }
  std::string fault = range_fault(wanted, static_cast<double>(value), node->text);
  if (fault.empty()) return value;
  state_->report(node->place, path_of(key), std::move(fault));
  return instead;
}

Eigen::Matrix3d ConfigMap::rotation(std::string_view key) const {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
  Key row_key = known(key, KeyKind::kRotation);
  row_key.items = 3;
  const YamlNode* const node = require(key);
  const std::string path = path_of(key);
  if (node == nullptr || !expect_items(*state_, *node, path, 3, "rows")) return matrix;
  const std::size_t faults_before = state_->faults.size();
  for (std::size_t i = 0; i < 3; ++i) {
    const auto row = quantities_of(*state_, *node->items[i], item_path(path, i), row_key);
    if (row) matrix.row(static_cast<Index>(i)) = *row;
  }
  if (state_->faults.size() > faults_before) return Eigen::Matrix3d::Identity();
  constexpr double kRounding = 1e-5;  // Files give six digits and more.
  if (!((matrix * matrix.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() <= kRounding) ||
      matrix.determinant() < 0.0) {
    const bool is_mirror = std::abs(matrix.determinant() + 1.0) <= kRounding;
    state_->report(node->place, path,
                   is_mirror ? "is a mirror image: turn one of its axes round"
                             : "must be a rotation matrix: orthonormal rows, determinant +1");
    return Eigen::Matrix3d::Identity();
  }
  return Eigen::Quaterniond(matrix).normalized().toRotationMatrix();
}

std::string ConfigMap::text(std::string_view key) const { return text_of(key, KeyKind::kText); }

std::string ConfigMap::text_of(std::string_view key, KeyKind kind) const {
  const YamlNode* const node = require(key, kind);
  if (node == nullptr || !expect_kind(*state_, *node, path_of(key), Kind::kScalar, "a text")) return "";
  if (node->text.empty()) state_->report(node->place, path_of(key), "must not be empty");
  return node->text;
}

std::vector<std::string> ConfigMap::texts(std::string_view key) const {
  const YamlNode* const node = require(key, KeyKind::kTexts);
  const std::string path = path_of(key);
  if (node == nullptr || !expect_kind(*state_, *node, path, Kind::kList, "a list of texts")) return {};
  if (node->items.empty()) state_->report(node->place, path, "must not be empty");
  std::vector<std::string> texts;
  for (std::size_t i = 0; i < node->items.size(); ++i) {
    expect_kind(*state_, *node->items[i], item_path(path, i), Kind::kScalar, "a text");
    texts.push_back(node->items[i]->text);
  }
  return texts;
}

bool ConfigMap::flag(std::string_view key) const {
  const YamlNode* const node = require(key, KeyKind::kFlag);
  if (node == nullptr || !expect_kind(*state_, *node, path_of(key), Kind::kScalar, "true or false")) return false;
  if (node->text != "true" && node->text != "false") {
    state_->report(node->place, path_of(key), "'" + node->text + "' is not true or false" + flag_hint(node->text));
  }
  return node->text == "true";
}

std::string ConfigMap::choice(std::string_view key) const {
  const std::vector<std::string_view> words = words_of(known(key, KeyKind::kChoice));
  const YamlNode* const node = require(key);
  const std::string wanted = "one of " + join(words, ", ");
  if (node == nullptr || !expect_kind(*state_, *node, path_of(key), Kind::kScalar, wanted)) {
    return std::string(words.front());
  }
  if (std::ranges::find(words, node->text) != words.end()) return node->text;
  state_->report(node->place, path_of(key),
                 "'" + node->text + "' is not " + wanted + did_you_mean(nearest_word(node->text, words)));
  return std::string(words.front());
}

std::filesystem::path ConfigMap::path(std::string_view key) const {
  std::filesystem::path written = text_of(key, KeyKind::kPath);
  const YamlNode* const node = find(key);
  if (node == nullptr || node->place.source > 0) return written;
  return (state_->file.parent_path() / written).lexically_normal();
}

ConfigMap ConfigMap::enter(YamlNode* node, std::string path) const {
  const Key* const here = find_key(state_->keys, table_path(path));
  const std::vector<std::string_view> names = names_below(state_->keys, table_path(path));
  const bool is_one = here != nullptr && here->kind == KeyKind::kOneOf;
  const std::string wanted = is_one ? fmt::format("a map of one of {}", join(names, ", ")) : "a map of keys and values";
  if (node == nullptr || !expect_kind(*state_, *node, path, Kind::kMap, wanted)) {
    return {state_, nullptr, std::move(path)};
  }
  node->was_entered = true;
  return {state_, node, std::move(path)};
}

ConfigMap ConfigMap::map(std::string_view key) const {
  YamlNode* const node = require(key);
  const std::vector<std::string_view> words = words_of(known(key));
  if (node != nullptr && node->kind == Kind::kScalar && !words.empty()) {
    const bool is_flag = std::ranges::find(words, "false") != words.end();
    const std::string meant = flag_hint(node->text);
    refuse(key, fmt::format("'{}' is neither {} nor a map of keys and values{}", node->text, join(words, ", "),
                            is_flag && !meant.empty() ? meant : did_you_mean(nearest_word(node->text, words))));
    return {state_, nullptr, path_of(key)};
  }
  return enter(node, path_of(key));
}

std::vector<ConfigMap> ConfigMap::list_of_maps(std::string_view key) const {
  const YamlNode* const node = require(key, KeyKind::kMaps);
  const std::string path = path_of(key);
  if (node == nullptr || !expect_kind(*state_, *node, path, Kind::kList, "a list of maps")) return {};
  std::vector<ConfigMap> maps;
  for (std::size_t i = 0; i < node->items.size(); ++i) {
    maps.push_back(enter(node->items[i].get(), item_path(path, i)));
  }
  return maps;
}

std::string ConfigMap::one_of() const {
  const std::vector<std::string_view> names = names_below(state_->keys, table_path(path_));
  std::string found;
  for (const std::string_view key : names) {
    if (!has(key)) continue;
    if (!found.empty()) {
      state_->report(find(key)->heading, path_of(key), "only one of " + join(names, ", ") + " may be given");
      return "";
    }
    found = key;
  }
  if (found.empty() && node_ != nullptr) {
    state_->report(node_->heading, path_, kNeedsOne + join(names, ", "));
  }
  return found;
}

void ConfigMap::use_default(std::string_view key, std::string_view value) const {
  if (node_ != nullptr) state_->defaults_used.push_back(path_of(key) + ": " + std::string(value));
}

bool ConfigMap::is_refused(std::string_view key) const {
  const std::string path = path_of(key);
  return std::ranges::any_of(state_->faults, [&](const YamlFault& fault) {
    return fault.key == path || fault.key.starts_with(path + "[") || fault.key.starts_with(path + ".");
  });
}

void ConfigMap::refuse(std::string_view key, std::string_view what) const {
  if (node_ == nullptr || is_refused(key)) return;
  const YamlNode* const node = find(key);
  state_->report(node == nullptr ? node_->heading : node->place, path_of(key), std::string(what));
}

}  // namespace thenar
