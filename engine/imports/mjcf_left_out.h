// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "engine/imports/xml_tree.h"

namespace thenar {

/// Adds a note for each kind of element of which an MJCF file, with its defaults, sets attributes that the import does
/// not read and that MuJoCo's model depends on, and for each kind of element that is not read. Attributes and elements
/// that a hand file has no place for (collisions, looks, solvers, joints' damping) are passed over.
void note_left_out(const XmlElement& mujoco, std::vector<std::string>& notes);

}  // namespace thenar
