#pragma once

#include <filesystem>

#include "engine/imports/xml_tree.h"

namespace thenar {

/// Puts the files that an MJCF file includes where it does so: what is below their roots. Their names are relative to
/// the folder of the first file, or to that of the file that includes them. Throws ConfigError and ReadError.
void include_files(XmlElement& root, const std::filesystem::path& file);

}  // namespace thenar
