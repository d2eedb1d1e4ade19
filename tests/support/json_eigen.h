// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace thenar {

nlohmann::json read_json(const std::filesystem::path& path);

/// A list of numbers.
Eigen::VectorXd vector_of(const nlohmann::json& list);

/// A list of rows.
Eigen::MatrixXd matrix_of(const nlohmann::json& rows);

/// The recorded small problems of one kind, "P1" (grasp forces), "P2" (muscle forces) or "LCP", by file name.
std::vector<nlohmann::json> recorded_small_problems(const std::string& kind);

}  // namespace thenar
