#pragma once

#include <optional>
#include <string_view>

#include "engine/imports/mjcf_defaults.h"

namespace thenar {

/// Tests whether it is the name of a kind of actuator, as elements and classes have it.
[[nodiscard]] bool is_actuator(std::string_view name);

/// Returns an actuator, or a class's actuator, in the terms that MuJoCo keeps of every kind: classes of one kind hold
/// for the others too. `gain` is the first number of gainprm and `force` the third, which is a muscle's largest force.
[[nodiscard]] XmlElement as_general(const XmlElement& actuator);

/// Returns the largest pull of an actuator [N], which was made general and is complete: a muscle pulls, another
/// actuator pulls with a negative force, and the gear multiplies forces. At most 0 if it can only push; nothing if the
/// file does not bound it. Throws ConfigError.
[[nodiscard]] std::optional<double> pull_N(const XmlElement& actuator, const MjcfDefaults& defaults);

}  // namespace thenar
