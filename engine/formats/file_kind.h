#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace thenar {

/// Returns what to say of a file that stands for another one, as downloads leave them: an archive, a web page, a pointer
/// of Git LFS. Empty for others.
[[nodiscard]] std::string parcel_in(std::string_view bytes);

/// Refuses the bytes of a surface's file that are plainly something else than its name says, in words that name it and
/// a remedy: an empty file, what parcel_in() tells, or another format of surfaces.
/// Throws FileError.
void expect_kind_of_name(std::string_view bytes, const std::filesystem::path& file);

}  // namespace thenar
