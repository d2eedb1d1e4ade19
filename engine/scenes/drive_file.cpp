// SPDX-License-Identifier: Apache-2.0
#include "engine/scenes/drive_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/formats/files.h"
#include "engine/formats/number_table.h"
#include "engine/formats/text.h"

namespace thenar {

namespace {

using Eigen::Index;

class Columns {
 public:
  Columns(const std::filesystem::path& file, const NumberTable& table) : file_(file), table_(table) {}

  [[nodiscard]] bool has(const std::string& name) const { return find(name).has_value(); }
  /// Throws FileError where it is missing or has no number.
  [[nodiscard]] Eigen::VectorXd column(const std::string& name) const {
    const std::optional<Index> at = find(name);
    if (!at) {
      const std::vector<std::string_view> names(table_.names.begin(), table_.names.end());
      throw FileError(file_, fmt::format("has no column '{}'{}", name, did_you_mean(nearest_word(name, names))));
    }
    Eigen::VectorXd numbers = table_.numbers.col(*at);
    for (Index i = 0; i < numbers.size(); ++i) {
      if (!std::isfinite(numbers[i])) fail(i, fmt::format("{} has no number", name));
    }
    return numbers;
  }
  [[noreturn]] void fail(Index row, const std::string& what) const {
    throw FileError(file_, fmt::format("line {}: {}", table_.lines[static_cast<std::size_t>(row)], what));
  }

 private:
  [[nodiscard]] std::optional<Index> find(const std::string& name) const {
    const auto at = std::find(table_.names.begin(), table_.names.end(), name);
    if (at == table_.names.end()) return std::nullopt;
    return at - table_.names.begin();
  }

  const std::filesystem::path& file_;
  const NumberTable& table_;
};

}  // namespace

DriveTable load_drive(const std::filesystem::path& file, const Hand& hand) {
  const NumberTable table = read_number_table(file);
  const Columns columns(file, table);
  DriveTable drive;
  drive.file = file;
  drive.time_s = columns.column("time_s");
  for (Index i = 1; i < drive.time_s.size(); ++i) {
    if (!(drive.time_s[i] > drive.time_s[i - 1])) columns.fail(i, "time_s must rise from row to row");
  }
  std::vector<std::string> joints, muscles;
  for (const Joint& joint : hand.joints) joints.push_back(joint.name + "_Nm");
  for (const Muscle& muscle : hand.muscles) {
    // A run whose muscles act has what it asked for in columns of its own.
    const std::string asked = muscle.name + "_asked_N";
    muscles.push_back(columns.has(asked) ? asked : muscle.name + "_N");
  }
  const auto has = [&](const std::string& name) { return columns.has(name); };
  const bool any_joint = std::any_of(joints.begin(), joints.end(), has);
  const bool any_muscle = std::any_of(muscles.begin(), muscles.end(), has);
  if (any_joint && any_muscle) throw FileError(file, "has both joint torques and muscle forces: one of them drives");
  if (!any_joint && !any_muscle) {
    throw FileError(file, fmt::format("drives nothing: it has neither torques of joints, such as '{}', nor {}",
                                      joints.empty() ? "" : joints[0],
                                      muscles.empty() ? "has this hand muscles"
                                                      : fmt::format("forces of muscles, such as '{}'", muscles[0])));
  }
  drive.muscles = any_muscle;
  const std::vector<std::string>& names = any_muscle ? muscles : joints;
  drive.values.resize(std::ssize(names), drive.time_s.size());
  for (Index i = 0; i < std::ssize(names); ++i) {
    drive.values.row(i) = columns.column(names[static_cast<std::size_t>(i)]).transpose();
    if (any_muscle && drive.values.row(i).minCoeff() < 0.0) {
      Index row = 0;
      drive.values.row(i).minCoeff(&row);
      columns.fail(row, fmt::format("{} is to push, and muscles pull", names[static_cast<std::size_t>(i)]));
    }
  }
  return drive;
}

}  // namespace thenar
