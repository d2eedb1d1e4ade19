#include "engine/imports/mjcf_actuator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "engine/formats/byte_source.h"

namespace thenar {

namespace {

/// What a kind of actuator is as a general one, by MuJoCo's XML reference. Empty: as its class has it.
struct ActuatorKind {
  std::string_view name, dynamics, gain_type, bias, gain;  ///< `gain`: the attribute that is gainprm's first number.
};

constexpr std::array kActuatorKinds{ActuatorKind{"general", "", "", "", ""},
                                    ActuatorKind{"motor", "none", "fixed", "none", ""},
                                    ActuatorKind{"position", "", "fixed", "affine", "kp"},
                                    ActuatorKind{"velocity", "none", "fixed", "affine", "kv"},
                                    ActuatorKind{"intvelocity", "integrator", "fixed", "affine", "kp"},
                                    ActuatorKind{"damper", "none", "affine", "none", ""},
                                    ActuatorKind{"cylinder", "filter", "fixed", "affine", "area"},
                                    ActuatorKind{"muscle", "muscle", "muscle", "muscle", ""},
                                    ActuatorKind{"adhesion", "none", "fixed", "none", "gain"},
                                    ActuatorKind{"plugin", "", "", "", ""}};

void set_attribute(XmlElement& element, std::string_view attribute, std::string_view value) {
  if (value.empty()) return;
  std::erase_if(element.attributes, [&](const auto& own) { return own.first == attribute; });
  element.attributes.emplace_back(attribute, value);
}

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

bool is_actuator(std::string_view name) {
  return std::ranges::find(kActuatorKinds, name, &ActuatorKind::name) != kActuatorKinds.end();
}

XmlElement as_general(const XmlElement& actuator) {
  XmlElement general = actuator;
  const auto kind = std::ranges::find(kActuatorKinds, std::string_view(actuator.name), &ActuatorKind::name);
  if (kind == kActuatorKinds.end()) return general;
  set_attribute(general, "dyntype", kind->dynamics);
  set_attribute(general, "gaintype", kind->gain_type);
  set_attribute(general, "biastype", kind->bias);
  if (actuator.name == "motor") set_attribute(general, "gain", "1");
  if (!kind->gain.empty()) set_attribute(general, "gain", actuator.text(kind->gain));
  const std::string gains = actuator.text("gainprm");
  const std::vector<std::string_view> words = words_of(gains);
  if (!words.empty()) set_attribute(general, "gain", words[0]);
  if (words.size() >= 3) set_attribute(general, "force", words[2]);
  return general;
}

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
