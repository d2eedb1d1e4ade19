// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "thenar/eigen_layout.h"

namespace thenar {

/// Named columns of numbers.
struct NumberTable {
  std::vector<std::string> names;
  Eigen::MatrixXd numbers;              ///< Rows x names; NaN for an empty cell and for "nan".
  std::vector<std::size_t> lines = {};  ///< Line number of each row, from 1.
};

/// Reads comma-separated values below a line of names, such as signals.csv; empty lines are skipped. Throws FileError
/// with the line of the error, ReadError if there is no such file.
[[nodiscard]] NumberTable read_number_table(const std::filesystem::path& file);

/// Reads the same from bytes.
[[nodiscard]] NumberTable parse_number_table(const std::filesystem::path& file, std::string_view bytes);

}  // namespace thenar
