// SPDX-License-Identifier: Apache-2.0
#include "engine/scenes/config_reader.h"

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace thenar {

namespace {

class ConfigReader final : public Visitor {
 public:
  explicit ConfigReader(const ConfigMap& root) : levels_{{root}} {}

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
  bool is_map(std::string_view name, bool) override { return here().is_map(name); }
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

void read_config(const ConfigMap& root, const std::function<void(Visitor&)>& show) {
  ConfigReader reader(root);
  show(reader);
}

}  // namespace thenar
