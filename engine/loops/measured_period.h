#pragma once

#include "engine/grasp/model.h"

namespace thenar {

/// The control period that this machine can keep for a scene, by measurement: twice the p99 of 200 control ticks on a
/// running grasp, rounded up to a whole 0.1 ms, at least one contact step and at most 5 ms, from where on control costs
/// accuracy. The model's own control period plays no part.
[[nodiscard]] double measured_control_period_s(const Model& model);

}  // namespace thenar
