// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "engine/imports/xml_tree.h"

namespace thenar {

/// Tests whether it is the name of a kind of actuator, as elements and classes have it.
[[nodiscard]] bool is_actuator(std::string_view name);

/// Returns an actuator, or a class's actuator, in the terms that MuJoCo keeps of every kind: classes of one kind hold
/// for the others too. `gain` is the first number of gainprm and `force` the third, which is a muscle's largest force.
[[nodiscard]] XmlElement as_general(const XmlElement& actuator);

}  // namespace thenar
