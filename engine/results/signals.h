#pragma once

#include <string>

#include "engine/grasp/model.h"
#include "engine/results/recording.h"

namespace thenar {

/// The recording as comma-separated values: a header with units, a row a tick.
[[nodiscard]] std::string signals_csv(const Model& model, const Recording& recording);

}  // namespace thenar
