// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "engine/scenes/config.h"
#include "engine/scenes/visitor.h"

namespace thenar {

/// Fills the fields of a description from a file: `show` gets a visitor that reads. `root`: the map that the
/// description is of.
void read_config(const ConfigMap& root, const std::function<void(Visitor&)>& show);

}  // namespace thenar
