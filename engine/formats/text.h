// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace thenar {

/// Finds the first byte that is not part of a character in UTF-8, or is part of a control character (U+0000 to U+001F,
/// U+007F to U+009F); npos: there is none. JSON must not contain such bytes, and a terminal obeys control characters.
[[nodiscard]] std::size_t first_unprintable(std::string_view text);

/// Returns the text with each such byte as "\xE9".
[[nodiscard]] std::string printable(std::string_view text);

/// Returns the text as a cell of comma-separated values: in quotes where needed (RFC 4180).
[[nodiscard]] std::string csv_cell(const std::string& text);

/// Returns the text in double quotes, as YAML reads it.
[[nodiscard]] std::string quoted(const std::string& words);

/// Returns a number with its noun: "1 hold", "2 holds".
[[nodiscard]] std::string counted(std::int64_t number, std::string_view what);

/// Returns the words with the separator between them.
[[nodiscard]] std::string join(std::span<const std::string_view> words, std::string_view separator);

/// Finds the candidate that the word may misspell: the first of those with the fewest wrong letters; empty if none is
/// near.
[[nodiscard]] std::string_view nearest_word(std::string_view word, std::span<const std::string_view> candidates);

/// Returns ", did you mean 'x'?", or nothing for an empty word.
[[nodiscard]] std::string did_you_mean(std::string_view nearest);

/// Returns the word with small letters in the place of A to Z.
[[nodiscard]] std::string lower_case(std::string_view word);

}  // namespace thenar
