// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/imports/body_tree.h"
#include "engine/imports/mjcf_defaults.h"

namespace thenar {

/// Adds the tendons, muscles and constraints of an MJCF file to the tree of its bodies. Throws ConfigError.
void read_ties(const XmlElement& mujoco, const MjcfDefaults& defaults, BodyTree& tree);

}  // namespace thenar
