#include "engine/scenes/scene_file.h"

#include <fmt/format.h>

#include <numbers>
#include <optional>
#include <utility>

#include "engine/formats/files.h"
#include "engine/formats/text.h"
#include "engine/scenes/config.h"
#include "engine/scenes/describe.h"
#include "engine/scenes/hand_file.h"
#include "engine/scenes/key_table.h"

namespace thenar {

namespace {

/// Fills the fields of a description from a file.
class SceneReader final : public Visitor {
 public:
  explicit SceneReader(const ConfigMap& root) : levels_{{root}} {}

  void per_joint(const KeyRow& row, Eigen::VectorXd& values, Eigen::Index joints) override {
    values = here().quantities(row.name, static_cast<std::size_t>(joints));
  }
  std::string word(const KeyRow& row, std::string_view) override { return here().word(row.name); }
  bool chooses(std::string_view name, bool) override {
    std::optional<std::string>& chosen = levels_.back().chosen;
    if (!chosen) chosen = here().one_of();
    return *chosen == name;
  }
  bool is_there(std::string_view name, bool) override {
    const std::size_t dot = name.find('.');
    if (dot == name.npos) return here().has(name);
    const std::string_view map = name.substr(0, dot);
    return here().is_map(map) && here().map(map).has(name.substr(dot + 1));
  }

  [[nodiscard]] bool reads() const override { return true; }
  bool has(std::string_view name) override { return here().has(name); }
  void refuse(std::string_view name, std::string_view what) override { here().refuse(name, what); }
  bool is_refused(std::string_view name) override { return here().is_refused(name); }
  void use_default(std::string_view name, std::string_view value) override { here().use_default(name, value); }
  std::string location(std::string_view name) override { return here().location(name); }

 private:
  struct Level {
    ConfigMap map;
    std::optional<std::string> chosen = {};  ///< The one key of a map of which one is there.
  };

  void number(const KeyRow& row, double& value) override { value = here().quantity(row.name); }
  void numbers(const KeyRow& row, Eigen::Ref<Eigen::VectorXd> values) override { values = here().quantities(row.name); }
  void count(const KeyRow& row, Eigen::Index& value) override { value = here().count(row.name); }
  void rotation(const KeyRow& row, Eigen::Matrix3d& value) override { value = here().rotation(row.name); }
  void flag(const KeyRow& row, bool& value) override { value = here().flag(row.name); }
  void text(const KeyRow& row, std::string& value) override { value = here().text(row.name); }
  void texts(const KeyRow& row, std::vector<std::string>& value) override { value = here().texts(row.name); }
  void path(const KeyRow& row, std::filesystem::path& value) override { value = here().path(row.name); }
  std::string choice_of(const KeyRow& row, std::string_view) override { return here().choice(row.name); }
  void enter(const KeyRow& row, KeyKind) override { levels_.push_back({here().map(row.name)}); }
  bool enters_map(const KeyRow& row, std::filesystem::path& file) override {
    const bool is_map = here().is_map(row.name);
    if (is_map) {
      enter(row, KeyKind::kMap);
    } else {
      path(row, file);
    }
    return is_map;
  }
  std::size_t begin_list(const KeyRow& row, std::size_t) override {
    return lists_.emplace_back(here().list_of_maps(row.name)).size();
  }
  void begin_item(const KeyRow&, std::size_t i) override { levels_.push_back({lists_.back()[i]}); }
  void leave() override { levels_.pop_back(); }
  void end_list() override { lists_.pop_back(); }

  [[nodiscard]] const ConfigMap& here() const { return levels_.back().map; }

  std::vector<Level> levels_;
  std::vector<std::vector<ConfigMap>> lists_;
};

}  // namespace

std::string in_words(const Tolerance& tolerance) {
  return fmt::format("{{position: {:.3g} mm, rotation: {:.3g} deg, force: {:.3g} %, moment: {:.3g} %, margin: {:.3g}}}",
                     1e3 * tolerance.position_m, tolerance.rotation_rad * 180.0 / std::numbers::pi,
                     100.0 * tolerance.force, 100.0 * tolerance.moment, tolerance.margin);
}

Scene load_scene(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
  if (is_hand_file(file)) {
    throw ConfigError({{printable(file.string()), "", "is a hand, which a scene names in hand.model, and no scene"}});
  }
  Config config(file, scene_keys(), overrides);
  const ConfigMap root = config.root();
  SceneReader reader(root);
  SceneFile read;
  describe(reader, read);
  try {
    config.finish();
  } catch (const ConfigError& error) {
    // A file may be there the next time: where that is all that is wrong, the scene is not.
    if (read.is_readable || error.diagnostics().size() > 1) throw;
    const std::string& place = error.diagnostics().front().location;
    throw ReadError(place, std::string(error.what()).substr(place.size() + 2));
  }
  Scene& scene = read.scene;
  scene.defaults_used = config.defaults_used();
  if (scene.only_needed && !root.has("tolerance")) {
    scene.defaults_used.push_back("tolerance: " + in_words(scene.tolerance));
  }
  return std::move(scene);
}

std::vector<std::filesystem::path> scene_files(const std::filesystem::path& scene,
                                               const std::vector<std::string>& overrides) {
  std::vector<std::filesystem::path> files{scene};
  const auto add = [&files](const std::filesystem::path& file) {
    if (!file.empty()) files.push_back(file);
  };
  const Config config(scene, scene_keys(), overrides);
  const ConfigMap root = config.root();
  if (root.is_map("hand") && !root.map("hand").has("slides")) add(found_hand(root.map("hand").path("model")));
  if (root.is_map("object") && root.map("object").is_map("shape")) {
    const ConfigMap shape = root.map("object").map("shape");
    if (shape.has("cloud")) add(shape.is_map("cloud") ? shape.map("cloud").path("file") : shape.path("cloud"));
  }
  if (root.is_map("control") && root.map("control").has("drive")) add(root.map("control").path("drive"));
  return files;
}

}  // namespace thenar
