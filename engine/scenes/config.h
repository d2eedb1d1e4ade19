// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "engine/scenes/keys.h"
#include "thenar/eigen_layout.h"

/// Strict reading of YAML files by a table of keys (engine/scenes/keys.h). Nothing in a file is ignored and nothing is
/// guessed: an unknown, doubled or missing key, a wrong or missing unit, a wrong type, a number that is not finite or
/// out of range is a diagnostic with its place. All diagnostics of a file are collected; a reader that found one
/// returns a harmless value of its type.
///
///     Config config("box_grasp.yaml", scene_keys(), {"time.step=0.5 ms"});
///     const ConfigMap time = config.root().map("time");
///     scene.step_s = time.quantity("step");  // of the dimension and in the range that the table has for time.step
///     config.finish();                       // throws ConfigError with all of them
namespace thenar {

/// One thing wrong with a file.
struct ConfigDiagnostic {
  std::string location;  ///< "file:line:column", or "--set key" for a value of the command line.
  std::string key;       ///< Full path, such as "object.shape.box[2]"; empty for a fault of the whole file.
  std::string message;   ///< The fault, and what would be right.
};

/// A file that is not a valid scene (exit code 2). what() has one line a diagnostic, in the order of the file:
///     configs/box_grasp.yaml:14:14: contact.band: -0.3 mm must be greater than zero
class ConfigError : public std::runtime_error {
 public:
  explicit ConfigError(const std::vector<ConfigDiagnostic>& diagnostics);
  [[nodiscard]] const std::vector<ConfigDiagnostic>& diagnostics() const noexcept { return diagnostics_; }

 private:
  std::vector<ConfigDiagnostic> diagnostics_;
};

struct YamlNode;     // One value of the file: engine/scenes/yaml_tree.h.
struct ConfigState;  // All that is known of the file: engine/scenes/config_state.h.

/// A map of the file: keys and values. Cheap to copy; valid as long as its Config.
///
/// The table says what a value may be. A missing key is read from its default, which Config::defaults_used() then
/// lists, or is reported if it has none. Values come in SI. A key that is not in the table, or is there of another
/// kind, is our own mistake: std::logic_error.
class ConfigMap {
 public:
  [[nodiscard]] bool has(std::string_view key) const;
  [[nodiscard]] bool is_map(std::string_view key) const;
  /// The one of the words that may stand for a quantity or a map, as in `gain: auto`; empty if the value is another or
  /// missing.
  [[nodiscard]] std::string word(std::string_view key) const;

  [[nodiscard]] double quantity(std::string_view key) const;
  [[nodiscard]] Eigen::VectorXd quantities(std::string_view key) const;
  /// One a joint of a hand; with no joints, which is the fault of another key, of any number.
  [[nodiscard]] Eigen::VectorXd quantities(std::string_view key, std::size_t joints) const;
  [[nodiscard]] Eigen::Index count(std::string_view key) const;
  /// A rotation matrix; what rounding in the file left is removed.
  [[nodiscard]] Eigen::Matrix3d rotation(std::string_view key) const;

  [[nodiscard]] std::string text(std::string_view key) const;
  [[nodiscard]] std::vector<std::string> texts(std::string_view key) const;
  [[nodiscard]] bool flag(std::string_view key) const;
  [[nodiscard]] std::string choice(std::string_view key) const;
  /// A path, relative to the file's folder; one given by --set is relative to the working directory.
  [[nodiscard]] std::filesystem::path path(std::string_view key) const;

  // Maps below this one. A map that is missing or no map is reported once, and its readers then report nothing.
  [[nodiscard]] ConfigMap map(std::string_view key) const;
  [[nodiscard]] std::vector<ConfigMap> list_of_maps(std::string_view key) const;
  /// The one key of this map, as in `shape: {box: …}`. Reports none or several and then returns an empty string.
  [[nodiscard]] std::string one_of() const;

  /// Lists a value that the caller takes for a key that is missing.
  void use_default(std::string_view key, std::string_view value) const;
  /// Returns true if `key` is reported already: its reader then gave a harmless value, which is not the file's.
  [[nodiscard]] bool is_refused(std::string_view key) const;
  /// Reports a fault that only the caller can see, at the place of `key` or, if that is missing, of this map. Says
  /// nothing about a key that is reported already.
  void refuse(std::string_view key, std::string_view what) const;
  /// Returns the place of the value of `key`, or of this map where it is missing: as ConfigDiagnostic::location.
  [[nodiscard]] std::string location(std::string_view key) const;
  /// Returns the full path of `key`.
  [[nodiscard]] std::string path_of(std::string_view key) const;

 private:
  friend class Config;
  ConfigMap(ConfigState* state, YamlNode* node, std::string path);

  /// The key of the table; `kind` is what its reader takes.
  [[nodiscard]] const Key& known(std::string_view key, std::optional<KeyKind> kind = {}) const;
  [[nodiscard]] YamlNode* find(std::string_view key) const;
  /// The value or its default; null if there is neither, which is reported.
  [[nodiscard]] YamlNode* require(std::string_view key, std::optional<KeyKind> kind = {}) const;
  [[nodiscard]] std::string text_of(std::string_view key, KeyKind kind) const;
  [[nodiscard]] ConfigMap enter(YamlNode* node, std::string path) const;

  ConfigState* state_;
  YamlNode* node_;  ///< Null where the file has no such map: an error that is reported already.
  std::string path_;
};

/// A YAML file with the values that the command line sets in it.
class Config {
 public:
  /// Reads `file`, whose keys are those of the table, which must outlive it; or `text`, which was read from it. Each
  /// override is "key.path=value", the value in YAML; the key need not be in the file. Throws FileError if the file
  /// cannot be read and ConfigError if it is no YAML.
  Config(const std::filesystem::path& file, Keys keys, const std::vector<std::string>& overrides = {},
         const std::optional<std::string>& text = {});
  ~Config();

  [[nodiscard]] ConfigMap root() const;
  /// Throws ConfigError if anything was wrong; a key that no reader asked for is wrong, too. Call it after reading
  /// and before using what was read: after a fault the values are harmless, but not those of the file.
  void finish();
  /// "key: value", in the order of reading, for every default that was taken.
  [[nodiscard]] const std::vector<std::string>& defaults_used() const noexcept;

 private:
  std::unique_ptr<ConfigState> state_;
};

}  // namespace thenar
