// SPDX-License-Identifier: Apache-2.0
#include "engine/imports/mjcf_pull.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

namespace thenar {

namespace {

/// The least and the largest force before the gear, infinite where nothing bounds it.
using Forces = std::array<double, 2>;
constexpr double kUnbounded_N = std::numeric_limits<double>::infinity();

Forces forces_of_gain(const XmlElement& actuator, const MjcfDefaults& defaults) {
  const std::string type = actuator.text("gaintype"), bias = actuator.text("biastype"),
                    dynamics = actuator.text("dyntype");
  const bool has_controls = defaults.limits(actuator, "ctrllimited", "ctrlrange");
  const auto controls = has_controls ? numbers(actuator, "ctrlrange", 2, 2) : std::nullopt;
  if (type == "muscle") {  // Its activation is within 0 and 1.
    const double force_N = number(actuator, "force").value_or(0.0);
    const double most = controls ? std::clamp((*controls)[1], 0.0, 1.0) : 1.0;
    return {force_N > 0.0 ? -most * force_N : -kUnbounded_N, 0.0};
  }
  const bool is_bare = (type.empty() || type == "fixed") && (bias.empty() || bias == "none") &&
                       dynamics != "integrator" && dynamics != "user";
  if (!is_bare || !controls) return {-kUnbounded_N, kUnbounded_N};
  const double gain = number(actuator, "gain").value_or(1.0);
  return {std::min(gain * (*controls)[0], gain * (*controls)[1]),
          std::max(gain * (*controls)[0], gain * (*controls)[1])};
}

}  // namespace

std::optional<double> pull_N(const XmlElement& actuator, const MjcfDefaults& defaults) {
  Forces forces_N = forces_of_gain(actuator, defaults);
  if (defaults.limits(actuator, "forcelimited", "forcerange")) {
    if (const auto range = numbers(actuator, "forcerange", 2, 2)) {
      forces_N = {std::clamp(forces_N[0], (*range)[0], std::max((*range)[0], (*range)[1])),
                  std::clamp(forces_N[1], (*range)[0], std::max((*range)[0], (*range)[1]))};
    }
  }
  const auto gear = numbers(actuator, "gear", 1, 6);
  const double factor = gear ? (*gear)[0] : 1.0;
  if (factor == 0.0) return 0.0;
  const double pull = -std::min(factor * forces_N[0], factor * forces_N[1]);
  return std::isfinite(pull) ? std::optional(pull) : std::nullopt;
}

}  // namespace thenar
