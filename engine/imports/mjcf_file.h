#pragma once

#include <filesystem>

#include "engine/imports/body_tree.h"
#include "engine/imports/xml_tree.h"

namespace thenar {

/// The bodies, tendons and constraints of an MJCF file, whose root is `mujoco` and whose included files are looked for
/// from `file` on. Throws ConfigError with file and line, and ReadError.
[[nodiscard]] BodyTree read_mjcf(XmlElement mujoco, const std::filesystem::path& file);

}  // namespace thenar
