// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/imports/body_tree.h"
#include "engine/imports/xml_tree.h"

namespace thenar {

/// Reads the links and joints of a URDF file with the root `robot`. Throws ConfigError with file and line.
[[nodiscard]] BodyTree read_urdf(const XmlElement& robot);

}  // namespace thenar
