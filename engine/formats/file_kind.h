#pragma once

#include <filesystem>
#include <string_view>

namespace thenar {

/// Refuses the bytes of a surface's file that are plainly something else than its name says, in words that name it and
/// a remedy: an empty file, an archive, a web page, a pointer of Git LFS, or another format of surfaces.
/// Throws FileError.
void expect_kind_of_name(std::string_view bytes, const std::filesystem::path& file);

}  // namespace thenar
