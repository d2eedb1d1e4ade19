// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "engine/imports/xml_tree.h"

namespace thenar {

/// Replaces an MJCF file's include elements by the contents below the included files' roots. Their names are relative
/// to the folder of the first file, or to that of the file that includes them. Throws ConfigError and ReadError.
/// The whole is as deep as one file may be, and so is the chain of files that include one another; `left`: read_xml().
void include_files(XmlElement& root, const std::filesystem::path& file, std::size_t& left);

}  // namespace thenar
