// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "engine/grasp/model.h"

namespace thenar {

/// The largest disturbances that a reflex can hold before a finger has slid as far as task.lost, or its pulp's radius.
struct ReflexReach {
  double load_N = 0.0;             ///< Largest load step.
  bool of_push = false;            ///< True if along the scene's push, else along the weight.
  double answer_s = 0.0;           ///< Time from that step to the response.
  std::optional<double> friction;  ///< Least friction at the end of a step, if friction is sensed.
  double slip_m = 0.0;             ///< Allowed slip.
};

/// Computes the reach at the scene's start, by first-order mechanics: the load X beyond friction slides at X / b until
/// the grip has risen, with b the viscosity of object and fingers against the slide. The response to a step of friction
/// is, a latency later, a grip that rises with the fingers' own lag; to a step of load, the reflex's pulse. Nothing:
/// the scene has no reflex, or the fingers do not hold it at rest.
[[nodiscard]] std::optional<ReflexReach> reflex_reach(const Model& model);

}  // namespace thenar
