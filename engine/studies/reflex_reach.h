#pragma once

#include <optional>

#include "engine/grasp/model.h"

namespace thenar {

/// What a reflex can hold before a finger has slid by what task.lost forgives, or by its pulp's radius.
struct ReflexReach {
  double load_N = 0.0;             ///< The largest load step,
  bool of_push = false;            ///< along the scene's push, or else along the weight.
  double answer_s = 0.0;           ///< From that step to the answer.
  std::optional<double> friction;  ///< The least friction that a step may end at; where friction is felt.
  double slip_m = 0.0;             ///< What is forgiven.
};

/// Of the scene's start, by first-order mechanics: what friction does not hold, X, slides at X / b until the grip has
/// risen, where b is what the object's and the fingers' viscosity hold against the slide. A step of friction is
/// answered a latency later by a grip that rises with the fingers' own lag, a step of load by the reflex's pulse.
/// Nothing: the scene has no reflex, or the fingers do not hold it at rest.
[[nodiscard]] std::optional<ReflexReach> reflex_reach(const Model& model);

}  // namespace thenar
