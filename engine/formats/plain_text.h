// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace thenar {

/// Returns the text of a file in UTF-8, without a byte order mark: a part of `bytes`, or, of a text in UTF-16, `store`.
/// UTF-16 is known by its mark, or by the zeros beside its first two letters. Throws FileError for UTF-32.
[[nodiscard]] std::string_view plain_text(std::string_view bytes, const std::filesystem::path& file,
                                          std::string& store);

}  // namespace thenar
