// SPDX-License-Identifier: Apache-2.0
#include "engine/imports/mjcf_actuator.h"

#include <algorithm>
#include <array>
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

}  // namespace thenar
