// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "engine/imports/body_tree.h"
#include "engine/imports/xml_tree.h"

namespace thenar {

/// Reads the bodies, tendons and constraints of an MJCF file with the root `mujoco`; included files are relative to
/// `file`. Throws ConfigError with file and line, and ReadError.
[[nodiscard]] BodyTree read_mjcf(XmlElement mujoco, const std::filesystem::path& file, std::size_t left);

}  // namespace thenar
