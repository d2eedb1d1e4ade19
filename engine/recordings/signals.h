// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "engine/grasp/model.h"
#include "engine/results/recording.h"

namespace thenar {

/// A recording as numbers.
struct SignalTable {
  std::vector<std::string> names;  ///< With units: "thumb_normal_N".
  Eigen::MatrixXd numbers;         ///< Ticks x names.
};
[[nodiscard]] SignalTable signal_table(const Model& model, const Recording& recording);

/// The same as comma-separated values: a header with units, a row a tick.
[[nodiscard]] std::string signals_csv(const Model& model, const Recording& recording);

}  // namespace thenar
