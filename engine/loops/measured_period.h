// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/grasp/model.h"

namespace thenar {

/// Measures the control period that this machine can keep for a scene: twice the p99 of 200 control ticks on a running
/// grasp, rounded up to a whole 0.1 ms, at least one contact step and at most 5 ms, above which accuracy suffers. It
/// does not depend on the model's own control period.
[[nodiscard]] double measured_control_period_s(const Model& model);

}  // namespace thenar
