// SPDX-License-Identifier: Apache-2.0
#include "tests/support/json_eigen.h"

#include <Eigen/Core>
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace thenar {

nlohmann::json read_json(const std::filesystem::path& path) {
  std::ifstream file(path);
  return nlohmann::json::parse(file);
}

Eigen::VectorXd vector_of(const nlohmann::json& list) {
  const auto values = list.get<std::vector<double>>();
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

Eigen::MatrixXd matrix_of(const nlohmann::json& rows) {
  Eigen::MatrixXd matrix(rows.size(), rows.at(0).size());
  for (std::size_t i = 0; i < rows.size(); ++i)
    matrix.row(static_cast<Eigen::Index>(i)) = vector_of(rows[i]).transpose();
  return matrix;
}

std::vector<nlohmann::json> recorded_small_problems(const std::string& kind) {
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(THENAR_TEST_DATA "/small")) paths.push_back(entry);
  std::sort(paths.begin(), paths.end());
  std::vector<nlohmann::json> problems;
  for (const auto& path : paths) {
    nlohmann::json problem = read_json(path);
    problem["file"] = path.filename().string();
    if (problem.at("problem") == kind) problems.push_back(std::move(problem));
  }
  return problems;
}

}  // namespace thenar
