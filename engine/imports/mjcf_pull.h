// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "engine/imports/mjcf_defaults.h"

namespace thenar {

/// Returns the largest pull of an actuator [N], which was made general and is complete: a muscle pulls, another
/// actuator pulls with a negative force, and the gear multiplies forces. At most 0 if it can only push; nothing if the
/// file does not bound it. Throws ConfigError.
[[nodiscard]] std::optional<double> pull_N(const XmlElement& actuator, const MjcfDefaults& defaults);

}  // namespace thenar
