#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <initializer_list>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "engine/scenes/units.h"
#include "thenar/eigen_layout.h"

/// Strict reading of YAML files. Nothing in a file is ignored and nothing is guessed: an unknown, doubled or missing
/// key, a wrong or missing unit, a wrong type, a number that is not finite or out of range is a diagnostic with its
/// place. All diagnostics of a file are collected; a reader that found one returns a harmless value of its type.
///
///     Config config("box_grasp.yaml", {"time.step=0.5 ms"});
///     const ConfigMap time = config.root().map("time");
///     scene.step_s = time.positive("step", Dimension::kTime);
///     config.finish();                                         // throws ConfigError with all of them
namespace thenar {

/// One thing wrong with a file.
struct ConfigDiagnostic {
  std::string location;  ///< "file:line:column", or "--set key" for a value of the command line.
  std::string key;       ///< Full path, such as "object.shape.box[2]"; empty for a fault of the whole file.
  std::string message;   ///< What is wrong, and what would be right.
};

/// A file that is not a valid scene (exit code 2). what() has one line a diagnostic, in the order of the file:
///     configs/box_grasp.yaml:14:14: contact.band: -0.3 mm must be greater than zero
class ConfigError : public std::runtime_error {
 public:
  explicit ConfigError(std::vector<ConfigDiagnostic> diagnostics);
  [[nodiscard]] const std::vector<ConfigDiagnostic>& diagnostics() const noexcept { return diagnostics_; }

 private:
  std::vector<ConfigDiagnostic> diagnostics_;
};

struct YamlNode;     // One value of the file: engine/scenes/yaml_tree.h.
struct ConfigState;  // All that is known of the file: config.cpp.

/// A map of the file: keys and values. Cheap to copy; valid as long as its Config.
///
/// Readers without a default report a missing key. Those named *_or take the default (in SI) and list it in
/// Config::defaults_used(). Values come in SI. A list must have exactly the length asked for.
class ConfigMap {
 public:
  [[nodiscard]] bool has(std::string_view key) const;
  [[nodiscard]] bool is_map(std::string_view key) const;

  // Numbers with a unit of the dimension.
  [[nodiscard]] double quantity(std::string_view key, Dimension dimension) const;
  [[nodiscard]] double positive(std::string_view key, Dimension dimension) const;
  [[nodiscard]] double non_negative(std::string_view key, Dimension dimension) const;
  [[nodiscard]] Eigen::Vector3d vector3(std::string_view key, Dimension dimension) const;
  [[nodiscard]] Eigen::Vector3d positive3(std::string_view key, Dimension dimension) const;
  [[nodiscard]] Eigen::VectorXd quantities(std::string_view key, Dimension dimension, Eigen::Index count) const;
  /// A positive quantity, or nullopt for the word `auto`.
  [[nodiscard]] std::optional<double> positive_or_auto(std::string_view key, Dimension dimension) const;

  // Plain numbers; the range includes its ends.
  [[nodiscard]] double number(std::string_view key, double min, double max) const;
  [[nodiscard]] Eigen::Index count(std::string_view key, Eigen::Index min, Eigen::Index max) const;
  [[nodiscard]] Eigen::Vector3d numbers3(std::string_view key) const;
  [[nodiscard]] Eigen::VectorXd numbers(std::string_view key, Eigen::Index count) const;
  /// A rotation matrix, a list of three rows; what rounding in the file left is removed.
  [[nodiscard]] Eigen::Matrix3d rotation3(std::string_view key) const;

  // Words.
  [[nodiscard]] std::string text(std::string_view key) const;
  [[nodiscard]] std::vector<std::string> texts(std::string_view key) const;  ///< A list of any length but zero.
  [[nodiscard]] bool flag(std::string_view key) const;                       ///< true or false
  [[nodiscard]] std::string choice(std::string_view key, std::initializer_list<std::string_view> names) const;
  /// A path, relative to the file's folder; one given by --set is relative to the working directory.
  [[nodiscard]] std::filesystem::path path(std::string_view key) const;

  // Maps below this one. A map that is missing or no map is reported once, and its readers then report nothing.
  [[nodiscard]] ConfigMap map(std::string_view key) const;
  [[nodiscard]] std::vector<ConfigMap> list_of_maps(std::string_view key) const;
  /// The one of `keys` that is there, as in `shape: {box: …}` or `shape: {sphere: …}`. Reports none or several and
  /// then returns an empty string.
  [[nodiscard]] std::string one_of(std::initializer_list<std::string_view> keys) const;

  [[nodiscard]] double positive_or(std::string_view key, Dimension dimension, double default_value) const;
  [[nodiscard]] double non_negative_or(std::string_view key, Dimension dimension, double default_value) const;
  [[nodiscard]] Eigen::Vector3d vector3_or(std::string_view key, Dimension dimension,
                                           const Eigen::Vector3d& default_value) const;
  [[nodiscard]] double number_or(std::string_view key, double min, double max, double default_value) const;
  [[nodiscard]] Eigen::Index count_or(std::string_view key, Eigen::Index min, Eigen::Index max,
                                      Eigen::Index default_value) const;
  [[nodiscard]] std::string choice_or(std::string_view key, std::initializer_list<std::string_view> names,
                                      std::string_view default_value) const;

  /// Whether `key` is reported already: its reader then gave a harmless value, which is not the file's.
  [[nodiscard]] bool is_refused(std::string_view key) const;
  /// Reports a fault that only the caller can see, at the place of `key` or, if that is missing, of this map. Says
  /// nothing about a key that is reported already.
  void refuse(std::string_view key, std::string_view what) const;
  /// The full path of `key`.
  [[nodiscard]] std::string path_of(std::string_view key) const;

 private:
  friend class Config;
  ConfigMap(ConfigState* state, YamlNode* node, std::string path);

  /// True if the value of `key` is this word, as in `gain: auto`; false if it is another or missing.
  [[nodiscard]] bool is_word(std::string_view key, std::string_view word) const;
  [[nodiscard]] YamlNode* find(std::string_view key) const;
  [[nodiscard]] YamlNode* require(std::string_view key) const;
  [[nodiscard]] ConfigMap enter(YamlNode* node, std::string path) const;
  void use_default(std::string_view key, const std::string& value) const;

  ConfigState* state_;
  YamlNode* node_;  ///< Null where the file has no such map: an error that is reported already.
  std::string path_;
};

/// A YAML file with the values that the command line sets in it.
class Config {
 public:
  /// Reads `file`. Each override is "key.path=value", the value in YAML; the key need not be in the file.
  /// Throws FileError if the file cannot be read and ConfigError if it is no YAML.
  explicit Config(const std::filesystem::path& file, const std::vector<std::string>& overrides = {});
  ~Config();
  Config(Config&&) noexcept;
  Config& operator=(Config&&) noexcept;

  [[nodiscard]] ConfigMap root() const;
  /// Throws ConfigError if anything was wrong; keys that no reader asked for are unknown keys. Call it after reading
  /// and before using what was read: after a fault the values are harmless, but not those of the file.
  void finish();
  /// "key: value" in SI, in the order of reading, for every default that was taken.
  [[nodiscard]] const std::vector<std::string>& defaults_used() const noexcept;

 private:
  std::unique_ptr<ConfigState> state_;
};

}  // namespace thenar
