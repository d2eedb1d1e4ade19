#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "engine/file_error.h"

namespace thenar {

/// All bytes of a file. Throws FileError if it cannot be read.
[[nodiscard]] std::string read_file(const std::filesystem::path& file);

/// Replaces a file by these bytes, whole or not at all. Throws FileError.
void write_file(const std::filesystem::path& file, std::string_view bytes);

/// Makes a folder for results and proves that it can be written to. Throws FileError.
void prepare_folder(const std::filesystem::path& folder);

}  // namespace thenar
