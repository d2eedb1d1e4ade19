#include "engine/scenes/config.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cassert>
#include <charconv>
#include <limits>
#include <numeric>
#include <sstream>
#include <tuple>
#include <utility>

#include "engine/formats/files.h"
#include "engine/formats/text.h"
#include "engine/scenes/yaml_tree.h"

namespace thenar {

using Eigen::Index;
using Kind = YamlNode::Kind;

struct ConfigState {
  std::filesystem::path file;
  std::vector<std::string> override_keys;
  std::unique_ptr<YamlNode> root;
  std::vector<YamlFault> faults;
  std::vector<std::string> defaults_used;

  void report(const Place& place, std::string key, std::string message) {
    faults.push_back({place, std::move(key), std::move(message)});
  }

  void throw_if_faulty();
};

namespace {

constexpr const char* kMissing = "this key is missing";

/// Levenshtein's distance: the fewest insertions, deletions and replacements that make `b` of `a`.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> above(b.size() + 1);
  std::iota(above.begin(), above.end(), std::size_t{0});
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t i = 0; i < a.size(); ++i) {
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      row[j + 1] = std::min({above[j + 1] + 1, row[j] + 1, above[j] + (a[i] == b[j] ? 0 : 1)});
    }
    std::swap(above, row);
  }
  return above[b.size()];
}

/// The candidate that the word may be a slip of; empty if none is near.
template <typename Words>
std::string_view nearest_word(std::string_view word, const Words& candidates) {
  std::string_view nearest;
  std::size_t least = std::max<std::size_t>(2, word.size() / 3) + 1;
  for (const std::string_view candidate : candidates) {
    const std::size_t distance = edit_distance(word, candidate);
    // At a distance of its whole length a short word is another word: `d` is no slip of `p`.
    if (distance >= least || distance >= std::min(word.size(), candidate.size())) continue;
    least = distance;
    nearest = candidate;
  }
  return nearest;
}

/// ", did you mean 'x'?" with the nearest candidate, or nothing if none is near.
template <typename Words>
std::string did_you_mean(std::string_view word, const Words& candidates) {
  const std::string nearest(nearest_word(word, candidates));
  return nearest.empty() ? nearest : ", did you mean '" + nearest + "'?";
}

template <typename Words>
std::string join(const Words& words, std::string_view separator) {
  std::string joined;
  for (const std::string_view word : words) {
    if (!joined.empty()) joined += separator;
    joined += word;
  }
  return joined;
}

std::string_view kind_name(Kind kind) {
  switch (kind) {
    case Kind::kNull:
      return "nothing";
    case Kind::kScalar:
      return "a single value";
    case Kind::kList:
      return "a list";
    case Kind::kMap:
      return "a map";
  }
  return "";
}

/// Whether `node` is of this kind; reports it otherwise.
bool expect_kind(ConfigState& state, const YamlNode& node, const std::string& path, Kind kind,
                 std::string_view wanted) {
  if (node.kind == kind) return true;
  // A value left out stands nowhere: its key does.
  const Place& place = node.kind == Kind::kNull ? node.heading : node.place;
  state.report(place, path, "must be " + std::string(wanted) + ", not " + std::string(kind_name(node.kind)));
  return false;
}

enum class Sign { kAny, kPositive, kNonNegative };

/// A quantity; after a fault 1, which is harmless for all signs.
double quantity_of(ConfigState& state, const YamlNode& node, const std::string& path, Dimension dimension,
                   Sign sign = Sign::kAny) {
  if (!expect_kind(state, node, path, Kind::kScalar, name_of(dimension))) return 1.0;
  Quantity quantity = read_quantity(node.text, dimension);
  if (quantity.fault.empty() && sign == Sign::kPositive && quantity.value <= 0.0) {
    quantity.fault = node.text + " must be greater than zero";
  }
  if (quantity.fault.empty() && sign == Sign::kNonNegative && quantity.value < 0.0) {
    quantity.fault = node.text + " must not be negative";
  }
  if (quantity.fault.empty()) return quantity.value;
  state.report(node.place, path, std::move(quantity.fault));
  return 1.0;
}

/// A list of quantities; nullopt after a fault in the list itself.
std::optional<Eigen::VectorXd> quantities_of(ConfigState& state, const YamlNode& node, const std::string& path,
                                             Dimension dimension, Index count, Sign sign = Sign::kAny) {
  const std::string wanted = "a list of " + std::to_string(count) + " values";
  if (!expect_kind(state, node, path, Kind::kList, wanted)) return std::nullopt;
  if (std::ssize(node.items) != count) {
    state.report(node.place, path, "must be " + wanted + ", not " + std::to_string(node.items.size()));
    return std::nullopt;
  }
  Eigen::VectorXd values(count);
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    values[static_cast<Index>(i)] = quantity_of(state, *node.items[i], item_path(path, i), dimension, sign);
  }
  return values;
}

std::unique_ptr<YamlNode> make_node(Kind kind, const Place& place) {
  auto node = std::make_unique<YamlNode>();
  node->kind = kind;
  node->place = node->heading = place;
  return node;
}

/// Adds "key.path=value" to the tree. The maps on its way are made where they are missing.
void apply_override(ConfigState& state, const std::string& override_text) {
  const std::size_t equals = override_text.find('=');
  const std::string path = override_text.substr(0, equals);
  state.override_keys.push_back(path);
  const std::size_t source = state.override_keys.size();
  const Place place{source};
  const bool has_empty_key = path.empty() || path.front() == '.' || path.back() == '.' || path.find("..") != path.npos;
  if (equals == std::string::npos || has_empty_key) {
    state.report(place, "", "write it as key=value, such as time.step=0.5 ms");
    return;
  }
  auto value = read_yaml(override_text.substr(equals + 1), source, state.faults);
  if (!value) value = make_node(Kind::kNull, place);

  YamlNode* map = state.root.get();
  std::string so_far;
  std::istringstream keys(path);
  for (std::string key; std::getline(keys, key, '.');) {
    if (map->kind != Kind::kMap) {
      state.report(place, path, so_far + " is not a map of keys and values");
      return;
    }
    so_far = key_path(so_far, key);
    auto entry = std::ranges::find(map->entries, key, &YamlNode::Entry::key);
    if (entry == map->entries.end()) {
      map->entries.push_back({key, place, make_node(Kind::kMap, place)});
      entry = map->entries.end() - 1;
    }
    if (so_far == path) {
      value->heading = entry->place = place;
      entry->value = std::move(value);
      return;
    }
    map = entry->value.get();
  }
}

void report_unknown_keys(ConfigState& state, const YamlNode& node, const std::string& path) {
  for (std::size_t i = 0; i < node.items.size(); ++i) report_unknown_keys(state, *node.items[i], item_path(path, i));
  if (node.kind != Kind::kMap || !node.was_entered) return;
  for (const YamlNode::Entry& entry : node.entries) {
    if (std::ranges::find(node.asked_keys, entry.key) == node.asked_keys.end()) {
      state.report(entry.place, key_path(path, entry.key), "unknown key" + did_you_mean(entry.key, node.asked_keys));
      // A key that is only misspelt is not missing besides.
      const std::string meant = key_path(path, nearest_word(entry.key, node.asked_keys));
      std::erase_if(state.faults, [&](const YamlFault& f) { return f.key == meant && f.message == kMissing; });
    } else {
      report_unknown_keys(state, *entry.value, key_path(path, entry.key));
    }
  }
}

std::string lines(const std::vector<ConfigDiagnostic>& diagnostics) {
  std::string text;
  for (const ConfigDiagnostic& d : diagnostics) {
    if (!text.empty()) text += '\n';
    // "--set key" has said it.
    const bool told = d.key.empty() || d.location == "--set " + d.key;
    text += d.location + ": " + (told ? "" : d.key + ": ") + d.message;
  }
  return text;
}

}  // namespace

void ConfigState::throw_if_faulty() {
  if (faults.empty()) return;
  const auto order = [](const YamlFault& f) { return std::tie(f.place, f.key, f.message); };
  std::ranges::sort(faults, {}, order);
  std::vector<ConfigDiagnostic> diagnostics;
  for (std::size_t i = 0; i < faults.size(); ++i) {
    const auto& [place, key, message] = faults[i];
    // What two readers found is one fault.
    if (i > 0 && order(faults[i]) == order(faults[i - 1])) continue;
    const std::string in_file = file.string() + ":" + std::to_string(place.line) + ":" + std::to_string(place.column);
    const std::string location = place.source == 0 ? in_file : "--set " + override_keys[place.source - 1];
    // Messages quote the file, whatever it holds.
    diagnostics.push_back({printable(location), printable(key), printable(message)});
  }
  throw ConfigError(std::move(diagnostics));
}

ConfigError::ConfigError(std::vector<ConfigDiagnostic> diagnostics)
    : std::runtime_error(lines(diagnostics)), diagnostics_(std::move(diagnostics)) {}

Config::Config(const std::filesystem::path& file, const std::vector<std::string>& overrides)
    : state_(std::make_unique<ConfigState>()) {
  state_->file = file;
  state_->root = read_yaml(read_file(file), 0, state_->faults);
  if (!state_->root) {
    if (state_->faults.empty()) state_->report({}, "", "the file is empty");
    state_->throw_if_faulty();
  }
  if (!expect_kind(*state_, *state_->root, "", Kind::kMap, "a map of keys and values")) state_->throw_if_faulty();
  for (const std::string& override_text : overrides) apply_override(*state_, override_text);
}

Config::~Config() = default;
Config::Config(Config&&) noexcept = default;
Config& Config::operator=(Config&&) noexcept = default;

ConfigMap Config::root() const {
  state_->root->was_entered = true;
  return {state_.get(), state_->root.get(), ""};
}

void Config::finish() {
  report_unknown_keys(*state_, *state_->root, "");
  state_->throw_if_faulty();
}

const std::vector<std::string>& Config::defaults_used() const noexcept { return state_->defaults_used; }

ConfigMap::ConfigMap(ConfigState* state, YamlNode* node, std::string path)
    : state_(state), node_(node), path_(std::move(path)) {}

std::string ConfigMap::path_of(std::string_view key) const { return key_path(path_, key); }

YamlNode* ConfigMap::find(std::string_view key) const {
  if (node_ == nullptr) return nullptr;
  if (std::ranges::find(node_->asked_keys, key) == node_->asked_keys.end()) node_->asked_keys.emplace_back(key);
  return node_->find(key);
}

YamlNode* ConfigMap::require(std::string_view key) const {
  YamlNode* const node = find(key);
  if (node == nullptr && node_ != nullptr) state_->report(node_->heading, path_of(key), kMissing);
  return node;
}

bool ConfigMap::has(std::string_view key) const { return find(key) != nullptr; }

bool ConfigMap::is_map(std::string_view key) const {
  const YamlNode* const node = find(key);
  return node != nullptr && node->kind == Kind::kMap;
}

bool ConfigMap::is_word(std::string_view key, std::string_view word) const {
  const YamlNode* const node = find(key);
  return node != nullptr && node->kind == Kind::kScalar && node->text == word;
}

double ConfigMap::quantity(std::string_view key, Dimension dimension) const {
  const YamlNode* const node = require(key);
  return node == nullptr ? 1.0 : quantity_of(*state_, *node, path_of(key), dimension);
}

double ConfigMap::positive(std::string_view key, Dimension dimension) const {
  const YamlNode* const node = require(key);
  return node == nullptr ? 1.0 : quantity_of(*state_, *node, path_of(key), dimension, Sign::kPositive);
}

double ConfigMap::non_negative(std::string_view key, Dimension dimension) const {
  const YamlNode* const node = require(key);
  return node == nullptr ? 1.0 : quantity_of(*state_, *node, path_of(key), dimension, Sign::kNonNegative);
}

std::optional<double> ConfigMap::positive_or_auto(std::string_view key, Dimension dimension) const {
  if (is_word(key, "auto")) return std::nullopt;
  return positive(key, dimension);
}

Eigen::VectorXd ConfigMap::quantities(std::string_view key, Dimension dimension, Index count) const {
  const YamlNode* const node = require(key);
  const auto values = node == nullptr ? std::nullopt : quantities_of(*state_, *node, path_of(key), dimension, count);
  return values.value_or(Eigen::VectorXd::Ones(count));
}

Eigen::Vector3d ConfigMap::vector3(std::string_view key, Dimension dimension) const {
  return quantities(key, dimension, 3);
}

Eigen::Vector3d ConfigMap::positive3(std::string_view key, Dimension dimension) const {
  const YamlNode* const node = require(key);
  const auto values =
      node == nullptr ? std::nullopt : quantities_of(*state_, *node, path_of(key), dimension, 3, Sign::kPositive);
  return values.value_or(Eigen::Vector3d::Ones());
}

Eigen::VectorXd ConfigMap::numbers(std::string_view key, Index count) const {
  return quantities(key, Dimension::kNone, count);
}

Eigen::Vector3d ConfigMap::numbers3(std::string_view key) const { return numbers(key, 3); }

Eigen::Matrix3d ConfigMap::rotation3(std::string_view key) const {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
  const YamlNode* const node = require(key);
  if (node == nullptr) return matrix;
  const std::string path = path_of(key);
  if (!expect_kind(*state_, *node, path, Kind::kList, "a list of 3 rows")) return matrix;
  if (node->items.size() != 3) {
    state_->report(node->place, path, "must be a list of 3 rows, not " + std::to_string(node->items.size()));
    return matrix;
  }
  bool whole = true;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto row = quantities_of(*state_, *node->items[i], item_path(path, i), Dimension::kNone, 3);
    if (row) matrix.row(static_cast<Index>(i)) = *row;
    whole = whole && row.has_value();
  }
  if (!whole) return Eigen::Matrix3d::Identity();
  constexpr double kRounding = 1e-5;  // Files give six digits and more.
  if (!((matrix * matrix.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() <= kRounding) ||
      matrix.determinant() < 0.0) {
    state_->report(node->place, path, "must be a rotation matrix: orthonormal rows, determinant +1");
    return Eigen::Matrix3d::Identity();
  }
  return Eigen::Quaterniond(matrix).normalized().toRotationMatrix();
}

double ConfigMap::number(std::string_view key, double min, double max) const {
  const YamlNode* const node = require(key);
  if (node == nullptr) return min;
  const std::size_t faults_before = state_->faults.size();
  const double value = quantity_of(*state_, *node, path_of(key), Dimension::kNone);
  if (state_->faults.size() > faults_before) return min;
  if (value >= min && value <= max) return value;
  const std::string bound =
      value < min ? "at least " + to_text(min, Dimension::kNone) : "at most " + to_text(max, Dimension::kNone);
  state_->report(node->place, path_of(key), node->text + " must be " + bound);
  return min;
}

Index ConfigMap::count(std::string_view key, Index min, Index max) const {
  const YamlNode* const node = require(key);
  if (node == nullptr || !expect_kind(*state_, *node, path_of(key), Kind::kScalar, "a whole number")) return min;
  Index value = 0;
  const char* const last = node->text.data() + node->text.size();
  const auto [end, error] = std::from_chars(node->text.data(), last, value);
  if (error == std::errc::invalid_argument || end != last) {
    state_->report(node->place, path_of(key), "'" + node->text + "' is not a whole number");
    return min;
  }
  const bool is_negative = node->text.starts_with('-');
  if (error == std::errc::result_out_of_range)
    value = is_negative ? std::numeric_limits<Index>::min() : std::numeric_limits<Index>::max();
  if (value >= min && value <= max && error == std::errc()) return value;
  const std::string bound = value < min ? "at least " + std::to_string(min) : "at most " + std::to_string(max);
  state_->report(node->place, path_of(key), node->text + " must be " + bound);
  return min;
}

std::string ConfigMap::text(std::string_view key) const {
  const YamlNode* const node = require(key);
  if (node == nullptr || !expect_kind(*state_, *node, path_of(key), Kind::kScalar, "a text")) return "";
  if (node->text.empty()) state_->report(node->place, path_of(key), "must not be empty");
  return node->text;
}

std::vector<std::string> ConfigMap::texts(std::string_view key) const {
  const YamlNode* const node = require(key);
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
  const YamlNode* const node = require(key);
  if (node == nullptr || !expect_kind(*state_, *node, path_of(key), Kind::kScalar, "true or false")) return false;
  if (node->text != "true" && node->text != "false") {
    state_->report(node->place, path_of(key), "'" + node->text + "' is not true or false");
  }
  return node->text == "true";
}

std::string ConfigMap::choice(std::string_view key, std::initializer_list<std::string_view> names) const {
  assert(names.size() > 0);
  std::string first(*names.begin());
  const YamlNode* const node = require(key);
  const std::string wanted = "one of " + join(names, ", ");
  if (node == nullptr || !expect_kind(*state_, *node, path_of(key), Kind::kScalar, wanted)) return first;
  if (std::ranges::find(names, node->text) != names.end()) return node->text;
  state_->report(node->place, path_of(key), "'" + node->text + "' is not " + wanted + did_you_mean(node->text, names));
  return first;
}

std::filesystem::path ConfigMap::path(std::string_view key) const {
  std::filesystem::path written = text(key);
  const YamlNode* const node = find(key);
  if (node == nullptr || node->place.source > 0) return written;
  return (state_->file.parent_path() / written).lexically_normal();
}

ConfigMap ConfigMap::enter(YamlNode* node, std::string path) const {
  if (node == nullptr || !expect_kind(*state_, *node, path, Kind::kMap, "a map of keys and values")) {
    return {state_, nullptr, std::move(path)};
  }
  node->was_entered = true;
  return {state_, node, std::move(path)};
}

ConfigMap ConfigMap::map(std::string_view key) const { return enter(require(key), path_of(key)); }

std::vector<ConfigMap> ConfigMap::list_of_maps(std::string_view key) const {
  const YamlNode* const node = require(key);
  const std::string path = path_of(key);
  if (node == nullptr || !expect_kind(*state_, *node, path, Kind::kList, "a list of maps")) return {};
  std::vector<ConfigMap> maps;
  for (std::size_t i = 0; i < node->items.size(); ++i) {
    maps.push_back(enter(node->items[i].get(), item_path(path, i)));
  }
  return maps;
}

std::string ConfigMap::one_of(std::initializer_list<std::string_view> keys) const {
  std::string found;
  for (const std::string_view key : keys) {
    if (!has(key)) continue;
    if (!found.empty()) {
      state_->report(find(key)->heading, path_of(key), "only one of " + join(keys, ", ") + " may be given");
      return "";
    }
    found = key;
  }
  if (found.empty() && node_ != nullptr) {
    state_->report(node_->heading, path_, "needs one of " + join(keys, ", "));
  }
  return found;
}

void ConfigMap::use_default(std::string_view key, const std::string& value) const {
  if (node_ != nullptr) state_->defaults_used.push_back(path_of(key) + ": " + value);
}

double ConfigMap::positive_or(std::string_view key, Dimension dimension, double default_value) const {
  if (has(key)) return positive(key, dimension);
  use_default(key, to_text(default_value, dimension));
  return default_value;
}

double ConfigMap::non_negative_or(std::string_view key, Dimension dimension, double default_value) const {
  if (has(key)) return non_negative(key, dimension);
  use_default(key, to_text(default_value, dimension));
  return default_value;
}

Eigen::Vector3d ConfigMap::vector3_or(std::string_view key, Dimension dimension,
                                      const Eigen::Vector3d& default_value) const {
  if (has(key)) return vector3(key, dimension);
  std::vector<std::string> texts;
  for (const double value : default_value) texts.push_back(to_text(value, dimension));
  use_default(key, "[" + join(texts, ", ") + "]");
  return default_value;
}

double ConfigMap::number_or(std::string_view key, double min, double max, double default_value) const {
  if (has(key)) return number(key, min, max);
  use_default(key, to_text(default_value, Dimension::kNone));
  return default_value;
}

Index ConfigMap::count_or(std::string_view key, Index min, Index max, Index default_value) const {
  if (has(key)) return count(key, min, max);
  use_default(key, std::to_string(default_value));
  return default_value;
}

std::string ConfigMap::choice_or(std::string_view key, std::initializer_list<std::string_view> names,
                                 std::string_view default_value) const {
  if (has(key)) return choice(key, names);
  use_default(key, std::string(default_value));
  return std::string(default_value);
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
