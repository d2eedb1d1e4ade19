// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace thenar {

/// Returns what to say of a file that stands for another one, as downloads leave them: an archive, a web page, a
/// pointer of Git LFS. Empty for others, and where the ending of its name says that it is such a file.
[[nodiscard]] std::string parcel_in(std::string_view bytes, std::string_view ending);

/// Returns what to say of the bytes of a surface's file that are plainly something else than the ending of its name
/// says, in words that name it and a remedy: an empty file, what parcel_in() tells, or another format. Else empty.
[[nodiscard]] std::string other_kind(std::string_view bytes, std::string_view ending);

}  // namespace thenar
